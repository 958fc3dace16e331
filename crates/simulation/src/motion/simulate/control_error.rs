//! Errors of controllers.

use robot_dynamics_core::algorithms::motion_error::{check_result, check_vector};
use robot_dynamics_core::{Model, MotionError, check_configuration};
use thiserror::Error;

use super::callback::CallbackError;
use crate::OperationalSpaceError;

/// An error of creating or calling a controller.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// The state, a gain or a given pose is invalid, or a torque overflows.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The reference motion is invalid.
    #[error("the reference: {0}")]
    Reference(#[source] MotionError),
    /// The frame cannot have the required acceleration.
    #[error(transparent)]
    OperationalSpace(#[from] OperationalSpaceError),
    /// An entry of a vector is NaN or infinite.
    #[error("{quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// The name of the vector.
        quantity: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value of the entry.
        value: f64,
    },
    /// A number is NaN or infinite.
    #[error("{quantity} is {value}; it must be finite")]
    BadNumber {
        /// The name of the number.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The matrix of a reference orientation is not a rotation.
    #[error("the reference's rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// The larger of max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// An error of a callback.
    #[error(transparent)]
    Callback(CallbackError),
}

impl From<CallbackError> for ControllerError {
    /// Keeps a `ControllerError` that a closure returns in its original variant.
    fn from(error: CallbackError) -> Self {
        match error.downcast_ref::<Self>() {
            Some(own) => own.clone(),
            None => Self::Callback(error),
        }
    }
}

/// Checks that a number is finite.
pub fn check_number(quantity: &'static str, value: f64) -> Result<(), ControllerError> {
    if value.is_finite() { Ok(()) } else { Err(ControllerError::BadNumber { quantity, value }) }
}

/// Checks that all entries of a vector are finite.
pub fn check_finite(quantity: &'static str, x: &[f64]) -> Result<(), ControllerError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(ControllerError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    }
}

/// Checks the time, the configuration and the velocity of a call of a controller.
pub fn check_controller_input(model: &Model, t: f64, q: &[f64], v: &[f64]) -> Result<(), ControllerError> {
    check_number("t", t)?;
    check_configuration(model, q).map_err(MotionError::from)?;
    Ok(check_vector(model, "v", v)?)
}

/// Checks that the torque is finite.
pub fn check_torque(tau: &[f64]) -> Result<(), ControllerError> {
    Ok(check_result("the controller's torque", tau)?)
}
