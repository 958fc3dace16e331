//! Errors of the derivatives of a step.

use robot_dynamics_core::SingularMass;
use robot_dynamics_integrators::{Integrator, IntegratorError};
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use super::integrate::explicit::explicit_names;
use super::simulate::StepError;

/// An error of the linearization or the pullback of a step, or of the pullback of a rollout.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "LinearizeStepError")]
#[doc(alias = "PullbackError")]
#[doc(alias = "DifferenceError")]
pub enum StepDerivativeError {
    /// The step, or a step from a state nearby, fails.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The row solves an equation in each step; only explicit rows have exact derivatives.
    #[error(
        "{integrator} solves an equation at each step, which is not differentiated; use an explicit row ({}), \
         or linearize_by_differences",
        explicit_names()
    )]
    Implicit {
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
}

impl Classified for StepDerivativeError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Step(error) => error.kind(),
            Self::Implicit { .. } => ErrorKind::Unsupported,
            Self::Discontinuous { .. } => ErrorKind::Infeasible,
        }
    }
}

impl From<InvalidInput> for StepDerivativeError {
    fn from(error: InvalidInput) -> Self {
        Self::Step(error.into())
    }
}

impl From<IntegratorError> for StepDerivativeError {
    fn from(error: IntegratorError) -> Self {
        Self::Step(error.into())
    }
}

impl From<SingularMass> for StepDerivativeError {
    fn from(error: SingularMass) -> Self {
        Self::Step(error.into())
    }
}
