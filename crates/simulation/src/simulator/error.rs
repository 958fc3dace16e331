//! Errors of building and running a simulation.

use robot_dynamics_core::Model;
use robot_dynamics_description::ModelError;
use robot_dynamics_integrators::{DynamicsError, IntegratorError};
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::constraints::ConstraintError;
use crate::motion::simulate::{ActuatedStepError, RunError, StepError, StepFault};
use crate::{CallbackError, ContactError};

/// An error of building a simulation.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The step, or the tolerance or the control period of adaptive steps, is out of its range.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// A ground, a surface or a height field has an invalid number.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The equalities do not fit the robot.
    #[error(transparent)]
    Equalities(#[from] ConstraintError),
    /// The links with gravity compensation do not form a valid model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The method does not support a request.
    #[error("method `{method}` {problem}")]
    Method {
        /// The name of the method.
        method: &'static str,
        /// The unsupported request, and the methods that support it.
        problem: String,
    },
    /// A ground was given, but the robot has no shape that can touch it.
    #[error("robot `{robot}` has no collision shape that can touch the ground{}", because(.left_out))]
    NothingTouches {
        /// The name of the robot.
        robot: String,
        /// The shapes that are left out, each with the reason.
        left_out: Vec<String>,
    },
    /// The dynamics of the method could not be set up.
    #[error(transparent)]
    Law(#[from] DynamicsError),
    /// A ground was combined with [`conservative`](super::SimulationBuilder::conservative) or with contacts
    /// switched off.
    #[error("a ground was given, but contacts are switched off; leave one of the two out")]
    GroundWithoutContacts,
}

impl Classified for SimulationError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Contact(error) => error.kind(),
            Self::Equalities(error) => error.kind(),
            Self::Model(error) => error.kind(),
            Self::Law(error) => error.kind(),
            Self::Method { .. } | Self::GroundWithoutContacts => ErrorKind::Unsupported,
            Self::NothingTouches { .. } => ErrorKind::Description,
        }
    }
}

fn because(left_out: &[String]) -> String {
    match left_out {
        [] => "; give its links <collision> shapes".into(),
        reasons => format!(": {}", reasons.join("; ")),
    }
}

/// An error of a step, by the kind of step.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MethodError {
    /// An error that any step can return.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// An error of explicit steps with actuators and springs.
    #[error(transparent)]
    Actuated(#[from] ActuatedStepError),
    /// An error of explicit and variational steps under equalities.
    #[error(transparent)]
    Constrained(#[from] ConstraintError),
    /// An error of a custom stepper.
    #[error(transparent)]
    Own(#[from] CallbackError),
    /// An error of adaptive steps.
    #[cfg(feature = "adaptive")]
    #[error(transparent)]
    Adaptive(#[from] crate::AdaptiveStepError),
}

impl Classified for MethodError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Integrator(error) => error.kind(),
            Self::Actuated(error) => error.kind(),
            Self::Constrained(error) => error.kind(),
            Self::Own(error) => error.kind(),
            #[cfg(feature = "adaptive")]
            Self::Adaptive(error) => error.kind(),
        }
    }
}

impl StepError for MethodError {
    fn error_kind(&self) -> ErrorKind {
        self.kind()
    }

    fn is_interruption(&self) -> bool {
        match self {
            Self::Integrator(error) => error.is_interruption(),
            #[cfg(feature = "adaptive")]
            Self::Adaptive(error) => error.is_interruption(),
            _ => false,
        }
    }

    fn fault(self, model: &Model) -> StepFault<Self> {
        fn widened<E: StepError + Into<MethodError>>(error: E, model: &Model) -> StepFault<MethodError> {
            match error.fault(model) {
                StepFault::NotFinite { quantity, index } => StepFault::NotFinite { quantity, index },
                StepFault::SingularMass(source) => StepFault::SingularMass(source),
                StepFault::Other(error) => StepFault::Other(error.into()),
            }
        }
        match self {
            Self::Integrator(error) => widened(error, model),
            Self::Actuated(error) => widened(error, model),
            Self::Constrained(error) => widened(error, model),
            Self::Own(error) => StepFault::Other(Self::Own(error)),
            #[cfg(feature = "adaptive")]
            Self::Adaptive(error) => widened(error, model),
        }
    }
}

/// An error of running a simulation.
pub type StepFailure = RunError<MethodError>;
