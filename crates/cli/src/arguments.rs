//! Numbers on the command line.

/// A positive, finite number.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("it must be positive and finite".into()),
        Err(_) => Err("it is not a number".into()),
    }
}

/// A finite number that is zero or more.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("it must be zero or positive, and finite".into()),
        Err(_) => Err("it is not a number".into()),
    }
}
