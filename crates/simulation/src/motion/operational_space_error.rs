//! Errors of operational-space quantities.

use robot_dynamics_core::MotionError;
use thiserror::Error;

/// An error of operational-space inertia or torque.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OperationalSpaceError {
    /// q or v is invalid, M is singular, or a result overflows.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A desired acceleration or torque is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// The name of the quantity.
        quantity: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value of the entry.
        value: f64,
    },
    /// The frame cannot accelerate in every chosen direction in this pose.
    #[error(
        "the frame cannot accelerate in every chosen direction: beside the later ones, `{row}` has the \
         mobility {pivot:e}; choose fewer rows, or leave the singular pose"
    )]
    Singular {
        /// The row at which the factorization failed.
        row: &'static str,
        /// The remaining mobility (J M⁻¹Jᵀ) of that row \[1/kg or 1/(kg·m²)\].
        pivot: f64,
    },
}

/// Checks that all entries of a vector are finite.
pub fn check_entries(quantity: &'static str, x: &[f64]) -> Result<(), OperationalSpaceError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(OperationalSpaceError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}
