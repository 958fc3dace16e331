//! Errors of adaptive steps.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Classified, ErrorKind};
use thiserror::Error;

use super::super::{StepError, StepFault};

/// An error of an adaptive step.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AdaptiveStepError {
    /// The tolerance requires steps below the rounding of time.
    #[error(
        "the tolerance asks for steps below {step:e} s, most of all at coordinate `{coordinate}`: the \
         forces are not smooth there, or the tolerance is below rounding; a looser tolerance, or a fixed step, goes on"
    )]
    StepTooSmall {
        /// The step \[s\].
        step: f64,
        /// The coordinate with the largest local error.
        coordinate: String,
    },
    /// The number of steps between two samples exceeds the limit.
    #[error(
        "{steps} steps after the sample before came no further: coordinate `{coordinate}` asks for steps of \
         {step:.1e} s there, as a stiff or a very light joint does; allow more (max_steps), or a looser tolerance"
    )]
    TooManySteps {
        /// The number of attempted steps.
        steps: usize,
        /// The step that the tolerance allows \[s\].
        step: f64,
        /// The coordinate with the largest local error.
        coordinate: String,
    },
    /// The motion grew until steps within the tolerance lost the digits of an angle or a position.
    #[error(
        "the motion grows without bound: `{coordinate}` moves at {speed:.2e} rad/s or m/s, and steps of {step:.1e} s follow \
         it within the tolerance, so that no shorter step helps; look at the controller's gains and for dampers with the wrong sign"
    )]
    Diverged {
        /// The fastest coordinate.
        coordinate: String,
        /// Its speed \[rad/s or m/s\].
        speed: f64,
        /// The last step \[s\].
        step: f64,
    },
    /// An error that any step can return.
    #[error(transparent)]
    Step(#[from] IntegratorError),
}

impl Classified for AdaptiveStepError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::StepTooSmall { .. } | Self::TooManySteps { .. } => ErrorKind::NotConverged,
            Self::Diverged { .. } => ErrorKind::Diverged,
            Self::Step(error) => error.kind(),
        }
    }
}

impl StepError for AdaptiveStepError {
    fn error_kind(&self) -> ErrorKind {
        self.kind()
    }

    fn is_interruption(&self) -> bool {
        matches!(self, Self::Step(error) if error.is_interruption())
    }

    fn fault(self, model: &Model) -> StepFault<Self> {
        match self {
            Self::Step(error) => match error.fault(model) {
                StepFault::NotFinite { quantity, index } => StepFault::NotFinite { quantity, index },
                StepFault::SingularMass(source) => StepFault::SingularMass(source),
                StepFault::Other(error) => StepFault::Other(Self::Step(error)),
            },
            other => StepFault::Other(other),
        }
    }
}
