//! Checks of arguments from JavaScript, where `undefined` becomes NaN.

#[cfg(feature = "chapter")]
use dynamics::Integrator;

use crate::LabError;

/// A finite number, or an error with its name.
pub(crate) fn number(name: &str, value: f64) -> Result<f64, LabError> {
    if value.is_finite() { Ok(value) } else { Err(LabError::new(format!("{name} is not a finite number"))) }
}

/// A positive finite number.
pub(crate) fn positive(name: &str, value: f64) -> Result<f64, LabError> {
    if number(name, value)? > 0.0 {
        Ok(value)
    } else {
        Err(LabError::new(format!("{name} must be positive, got {value}")))
    }
}

/// A finite number that is not negative.
#[cfg(any(feature = "chapter", feature = "robots"))]
pub(crate) fn not_negative(name: &str, value: f64) -> Result<f64, LabError> {
    if number(name, value)? >= 0.0 {
        Ok(value)
    } else {
        Err(LabError::new(format!("{name} must not be negative, got {value}")))
    }
}

/// A list of the right length, all finite.
pub(crate) fn finite(name: &str, values: &[f64], length: usize) -> Result<(), LabError> {
    if values.len() != length {
        return Err(LabError::new(format!("{name} needs {length} numbers, got {}", values.len())));
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(LabError::new(format!("{name}[{index}] is not a finite number"))),
        None => Ok(()),
    }
}

/// A vector of `N` finite numbers.
#[cfg(feature = "chapter")]
pub(crate) fn vector<const N: usize>(
    name: &str,
    values: &[f64],
) -> Result<nalgebra::SVector<f64, N>, LabError> {
    finite(name, values, N)?;
    Ok(nalgebra::SVector::from_column_slice(values))
}

/// A row of the library's table of integrators.
#[cfg(feature = "chapter")]
pub(crate) fn integrator(name: &str) -> Result<Integrator, LabError> {
    Ok(Integrator::from_name(name)?)
}
