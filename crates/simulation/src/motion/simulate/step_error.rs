//! Errors of a step.

use robot_dynamics_core::SingularMass;
use robot_dynamics_integrators::{Integrator, IntegratorError};
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use super::CallbackError;
use crate::equality::error::ConstraintError;
use crate::motion::integrate::explicit::explicit_names;

/// An error of a step by any method, of its derivatives, and of the pullback of a step or a rollout. A run
/// adds the time and the coordinate: [`RunError`](crate::RunError).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "MethodError")]
#[doc(alias = "ActuatedStepError")]
#[doc(alias = "AdaptiveStepError")]
#[doc(alias = "StepDerivativeError")]
#[doc(alias = "LinearizeStepError")]
#[doc(alias = "PullbackError")]
pub enum StepError {
    /// An invalid argument, a number that is not finite, an iteration that did not converge, or an interrupt.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// M is singular: some motion has no inertia in this configuration.
    #[error(transparent)]
    SingularMass(#[from] SingularMass),
    /// The equalities contradict each other, or the start violates them.
    #[error(transparent)]
    Constraint(ConstraintError),
    /// The row has no explicit stages, so it cannot evaluate actuators.
    #[error(
        "`{integrator}` holds its forces over a step, actuators follow the state; take one of {}",
        explicit_names()
    )]
    NotExplicit {
        /// The name of the row.
        integrator: &'static str,
    },
    /// The tolerance of adaptive steps requires steps below the rounding of time.
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
    /// The number of adaptive steps between two samples exceeds the limit.
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
    /// The motion grew until adaptive steps within the tolerance lost the digits of an angle or a position.
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
    /// The derivatives or the pullback of a step by a row that solves an equation in each step.
    #[error(
        "{integrator} solves an equation at each step, which is not differentiated; use an explicit row ({}), \
         or linearize_by_differences",
        explicit_names()
    )]
    NotDifferentiable {
        /// The requested row.
        integrator: Integrator,
    },
    /// The step is discontinuous on both sides of the state and has no derivative.
    #[error(
        "the step has no derivative by the {quantity} of `{coordinate}`: it jumps on both sides of this state, as contacts open or close \
         there; linearise at a state that is not at the edge of a contact, or with another step length"
    )]
    Discontinuous {
        /// The perturbed quantity: `q`, `v` or `tau`.
        quantity: &'static str,
        /// The perturbed coordinate.
        coordinate: String,
    },
    /// The step has no derivatives by controls, inertial parameters and friction.
    #[error(
        "the step has no derivatives by parameters because of {reason}; use steps of `implicit` without it, or \
         differences of steps"
    )]
    ParametersNotDifferentiable {
        /// The part of the step without an analytic derivative.
        reason: &'static str,
    },
    /// A custom stepper failed.
    #[error(transparent)]
    Callback(#[from] CallbackError),
}

impl StepError {
    /// Whether an interrupt ended the step; the run then ends as if its observer had stopped it.
    pub(crate) fn is_interruption(&self) -> bool {
        *self == Self::Integrator(IntegratorError::Interrupted)
    }
}

impl Classified for StepError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Integrator(error) => error.kind(),
            Self::SingularMass(error) => error.kind(),
            Self::Constraint(error) => error.kind(),
            Self::NotExplicit { .. }
            | Self::NotDifferentiable { .. }
            | Self::ParametersNotDifferentiable { .. } => ErrorKind::Unsupported,
            Self::Discontinuous { .. } => ErrorKind::Infeasible,
            Self::StepTooSmall { .. } | Self::TooManySteps { .. } => ErrorKind::NotConverged,
            Self::Diverged { .. } => ErrorKind::Diverged,
            Self::Callback(error) => error.kind(),
        }
    }
}

impl From<InvalidInput> for StepError {
    fn from(error: InvalidInput) -> Self {
        Self::Integrator(error.into())
    }
}

impl From<ConstraintError> for StepError {
    /// Keeps the errors that every step can have in their own variants.
    fn from(error: ConstraintError) -> Self {
        match error {
            ConstraintError::Input(error) => error.into(),
            ConstraintError::Step(error) => error.into(),
            ConstraintError::SingularMass(error) => error.into(),
            error => Self::Constraint(error),
        }
    }
}
