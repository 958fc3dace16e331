//! Why a simulation could not be made, or could not go on.

use dynamics::{DynamicsError, IntegratorError};
use thiserror::Error;

use crate::constraint::{ConstrainedMotionError, ConstraintSetError};
use crate::motion::simulate::{ActuatedStepError, RunError, StepError, StepFault};
use crate::{CallbackError, ContactError, Model, ModelError};

/// Why a simulation could not be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// A step that is not positive and finite.
    #[error("the step must be positive and finite, got {step} s")]
    Step {
        /// As given \[s\].
        step: f64,
    },
    /// A ground, a surface or a height field with an invalid number.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The equalities do not fit the robot.
    #[error(transparent)]
    Equalities(#[from] ConstraintSetError),
    /// The compensated parts of the links' weights make no robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A method that does not know what was asked for.
    #[error("method `{method}` {problem}")]
    Method {
        /// Its name.
        method: &'static str,
        /// The request that it does not support, and the methods that do.
        problem: String,
    },
    /// A ground was given, and the robot has no shape that can touch it.
    #[error("robot `{robot}` has no collision shape that can touch the ground{}", because(.left_out))]
    NothingTouches {
        /// The robot.
        robot: String,
        /// Shapes that are left out, each with the reason.
        left_out: Vec<String>,
    },
    /// The tolerance or the control period of adaptive steps is invalid.
    #[cfg(feature = "adaptive")]
    #[error(transparent)]
    Adaptive(#[from] crate::AdaptiveOptionsError),
    /// The law of the method could not be set up.
    #[error(transparent)]
    Law(#[from] DynamicsError),
    /// A ground together with [`conservative`](super::SimulationBuilder::conservative) or without contacts.
    #[error("a ground was given, but contacts are switched off; leave one of the two out")]
    GroundWithoutContacts,
}

fn because(left_out: &[String]) -> String {
    match left_out {
        [] => "; give its links <collision> shapes".into(),
        reasons => format!(": {}", reasons.join("; ")),
    }
}

/// Why a step could not be taken, by the kind of step.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MethodError {
    /// As for any step.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// An error of explicit steps with actuators and springs.
    #[error(transparent)]
    Actuated(#[from] ActuatedStepError),
    /// An error of explicit and variational steps under equalities.
    #[error(transparent)]
    Constrained(#[from] ConstrainedMotionError),
    /// An error of a stepper of one's own.
    #[error(transparent)]
    Own(#[from] CallbackError),
    /// An error of adaptive steps.
    #[cfg(feature = "adaptive")]
    #[error(transparent)]
    Adaptive(#[from] crate::AdaptiveStepError),
}

impl StepError for MethodError {
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

/// Why a simulation could not go on.
pub type StepFailure = RunError<MethodError>;
