//! Errors of controllers.

use robot_dynamics_core::{Model, MotionError, SingularMass, check_configuration, check_vector};
use robot_dynamics_number::{Classified, ErrorKind, InputProblem, InvalidInput, check_number, check_result};
use thiserror::Error;

use super::callback::CallbackError;

/// An error of creating or calling a controller, or of the operational-space dynamics that it uses.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "OperationalSpaceError")]
pub enum ControllerError {
    /// The state, the reference, a gain or a given pose is invalid, M is singular, or a result overflows.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The frame cannot accelerate in every chosen direction in this pose.
    #[error(
        "the frame cannot accelerate in every chosen direction: beside the later ones, `{row}` has the \
         mobility {pivot:e}; choose fewer rows, or leave the singular pose"
    )]
    SingularPose {
        /// The row at which the factorization failed.
        row: &'static str,
        /// The remaining mobility (J M⁻¹Jᵀ) of that row \[1/kg or 1/(kg·m²)\].
        pivot: f64,
    },
    /// An error of a callback.
    #[error(transparent)]
    Callback(CallbackError),
}

impl Classified for ControllerError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Motion(error) => error.kind(),
            Self::SingularPose { .. } => ErrorKind::Singular,
            Self::Callback(error) => error.kind(),
        }
    }
}

impl From<InvalidInput> for ControllerError {
    fn from(error: InvalidInput) -> Self {
        Self::Motion(error.into())
    }
}

impl From<SingularMass> for ControllerError {
    fn from(error: SingularMass) -> Self {
        Self::Motion(error.into())
    }
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

/// Checks the time, the configuration and the velocity of a call of a controller.
pub fn check_controller_input(model: &Model, t: f64, q: &[f64], v: &[f64]) -> Result<(), InvalidInput> {
    check_number("t", t)?;
    check_configuration(model, q)?;
    check_vector(model, "v", v)
}

/// Checks that every torque that enters a step is finite.
pub(crate) fn check_input_torque(model: &Model, tau: &[f64]) -> Result<(), InvalidInput> {
    check_vector(model, "torque", tau)
}

/// Checks that the torque is finite.
pub fn check_torque(tau: &[f64]) -> Result<(), InvalidInput> {
    check_result("the controller's torque", tau)
}

/// The error for an M that could not be factored.
pub fn singular_mass(model: &Model, q: &[f64]) -> ControllerError {
    let overflow = || InvalidInput::new("M⁻¹", InputProblem::Overflow { value: f64::INFINITY }).into();
    model.inverse_mass_matrix(q).err().unwrap_or_else(overflow).into()
}
