//! Why a controller gives no torque, or cannot be made.

use thiserror::Error;

use super::callback::CallbackError;
use crate::algorithms::motion_error::{check_result, check_vector};
use crate::{Model, MotionError, OperationalSpaceError, check_configuration};

/// Why a controller gives no torque, or cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// The state, a gain or a pose given is wrong, or a torque too large to represent.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The motion to follow is wrong.
    #[error("the reference: {0}")]
    Reference(#[source] MotionError),
    /// The frame cannot accelerate as it must.
    #[error(transparent)]
    OperationalSpace(#[from] OperationalSpaceError),
    /// An entry of a vector is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
        /// Which entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A number is NaN or infinite.
    #[error("{quantity} is {value}; it must be finite")]
    BadNumber {
        /// Which number.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The matrix of an orientation to follow is not a rotation.
    #[error("the reference's rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// What a function handed to the library says.
    #[error(transparent)]
    Callback(CallbackError),
}

impl From<CallbackError> for ControllerError {
    /// An error of this kind that a closure passes on stays what it was.
    fn from(error: CallbackError) -> Self {
        match error.downcast_ref::<Self>() {
            Some(own) => own.clone(),
            None => Self::Callback(error),
        }
    }
}

/// Refuses a number that is not finite.
pub(crate) fn check_number(quantity: &'static str, value: f64) -> Result<(), ControllerError> {
    if value.is_finite() { Ok(()) } else { Err(ControllerError::BadNumber { quantity, value }) }
}

/// Refuses a vector with an entry that is not finite.
pub(crate) fn check_finite(quantity: &'static str, x: &[f64]) -> Result<(), ControllerError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(ControllerError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}

/// Refuses a time, a configuration and a velocity at which no controller can be asked.
pub(crate) fn check_moment(model: &Model, t: f64, q: &[f64], v: &[f64]) -> Result<(), ControllerError> {
    check_number("t", t)?;
    check_configuration(model, q).map_err(MotionError::from)?;
    Ok(check_vector(model, "v", v)?)
}

/// Refuses a torque that overflowed.
pub(crate) fn check_torque(tau: &[f64]) -> Result<(), ControllerError> {
    Ok(check_result("the controller's torque", tau)?)
}
