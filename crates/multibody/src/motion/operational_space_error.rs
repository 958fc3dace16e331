//! Why a frame has no operational space, or no torque in it.

use thiserror::Error;

use crate::MotionError;

/// Why a frame has no operational space, or no torque in it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OperationalSpaceError {
    /// q or v is wrong, M is singular, or a result is too large.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// An acceleration or a torque asked for is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
        /// Which entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A pose from which the frame cannot accelerate in every chosen direction.
    #[error(
        "the frame cannot accelerate in every chosen direction: beside the later ones, `{row}` has the \
         mobility {pivot:e}; choose fewer rows, or leave the singular pose"
    )]
    Singular {
        /// The row at which the factorisation broke down.
        row: &'static str,
        /// What is left of its mobility (J M⁻¹Jᵀ) \[1/kg or 1/(kg·m²)\].
        pivot: f64,
    },
}

/// Refuses a vector with an entry that is not finite.
pub(crate) fn check_entries(quantity: &'static str, x: &[f64]) -> Result<(), OperationalSpaceError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(OperationalSpaceError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}
