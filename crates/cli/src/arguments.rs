//! Parsers of numbers on the command line.

/// A positive, finite number.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("the number must be positive and finite".into()),
        Err(_) => Err("not a number".into()),
    }
}

/// A finite number that is zero or more.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("the number must be finite, 0 or more".into()),
        Err(_) => Err("not a number".into()),
    }
}
