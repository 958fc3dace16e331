//! Why data give no parameters.

use thiserror::Error;

/// Why data give no parameters.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// Fewer equations than parameters to find.
    #[error(
        "{equations} equations for {unknowns} base parameters; record at least {} more states",
        (.unknowns - .equations).div_ceil((*.coordinates).max(1))
    )]
    TooFewData {
        /// Rows of W.
        equations: usize,
        /// Base parameters.
        unknowns: usize,
        /// nv.
        coordinates: usize,
    },
    /// A sample that is not finite, or no configuration.
    #[error("sample {sample}: {reason}")]
    BadSample {
        /// Which sample.
        sample: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A number given is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
        /// Which entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The numbers given are finite, what follows from them is not.
    #[error("{quantity} is not finite: the numbers given are too large to compute it; check their units")]
    Overflow {
        /// Which result.
        quantity: &'static str,
    },
    /// The data do not excite what the base parameters were found from.
    #[error(
        "the data determine {rank} of the {unknowns} base parameters; not `{missing}`, for one: move more of the robot"
    )]
    NotExcited {
        /// The rank of W on the base columns.
        rank: usize,
        /// Base parameters.
        unknowns: usize,
        /// The worst-determined one.
        missing: String,
    },
    /// A list of parameters of the wrong length.
    #[error("{found} inertial parameters, the robot has {expected}")]
    WrongLength {
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        expected: usize,
    },
}

/// Refuses numbers that are not finite.
pub(super) fn check_entries(quantity: &'static str, x: &[f64]) -> Result<(), IdentificationError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(IdentificationError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}

/// Refuses a result that overflowed.
pub(super) fn check_results<'a>(
    quantity: &'static str,
    x: impl IntoIterator<Item = &'a f64>,
) -> Result<(), IdentificationError> {
    let finite = x.into_iter().all(|x| x.is_finite());
    if finite { Ok(()) } else { Err(IdentificationError::Overflow { quantity }) }
}
