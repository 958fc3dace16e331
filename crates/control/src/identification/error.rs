//! Errors of parameter identification.

use thiserror::Error;

/// An error of parameter identification.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// There are fewer equations than unknown parameters.
    #[error(
        "{equations} equations for {unknowns} base parameters; record at least {} more states",
        (.unknowns - .equations).div_ceil((*.coordinates).max(1))
    )]
    TooFewData {
        /// The number of rows of W.
        equations: usize,
        /// The number of base parameters.
        unknowns: usize,
        /// nv.
        coordinates: usize,
    },
    /// A sample has an invalid configuration or a number that is not finite.
    #[error("sample {sample}: {reason}")]
    BadSample {
        /// The index of the sample.
        sample: usize,
        /// The problem with the sample.
        reason: String,
    },
    /// A given number is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// The name of the quantity.
        quantity: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value of the entry.
        value: f64,
    },
    /// The given numbers are finite, but a result is not.
    #[error("{quantity} is not finite: the numbers given are too large to compute it; check their units")]
    Overflow {
        /// The name of the result.
        quantity: &'static str,
    },
    /// The data do not excite all of the base parameters.
    #[error(
        "the data determine {rank} of the {unknowns} base parameters; not `{missing}`, for one: move more of the robot"
    )]
    NotExcited {
        /// The rank of W on the base columns.
        rank: usize,
        /// The number of base parameters.
        unknowns: usize,
        /// The base parameter that is determined worst.
        missing: String,
    },
    /// A list of parameters has the wrong length.
    #[error("{found} inertial parameters, the robot has {expected}")]
    WrongLength {
        /// The given length.
        found: usize,
        /// The required length.
        expected: usize,
    },
}

/// Checks that numbers are finite.
pub(super) fn check_entries(quantity: &'static str, x: &[f64]) -> Result<(), IdentificationError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(IdentificationError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}

/// Checks that results are finite.
pub(super) fn check_results<'a>(
    quantity: &'static str,
    x: impl IntoIterator<Item = &'a f64>,
) -> Result<(), IdentificationError> {
    let finite = x.into_iter().all(|x| x.is_finite());
    if finite { Ok(()) } else { Err(IdentificationError::Overflow { quantity }) }
}
