//! Errors of whole-body control.

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use robot_dynamics_simulation::{CallbackError, ControllerError};
use thiserror::Error;

use super::solution::Limit;

/// The error of [`WholeBodyControl::solve`](super::WholeBodyControl::solve).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WholeBodyError {
    /// The state, a reference, a gain or a limit is invalid, or a result overflows.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// No accelerations and forces satisfy the dynamics, the contacts and the limits together.
    #[error(
        "no motion satisfies the dynamics, the contacts and the limits: {limit} contradicts the others; relax it, or \
         hold other contacts"
    )]
    Infeasible {
        /// The limit at which the contradiction was found.
        limit: Limit,
    },
    /// The held contacts contradict each other or the joints: they allow no acceleration.
    #[error(
        "the held contacts contradict each other: their equations differ by {residual:e} in a direction that they \
         share; hold fewer contacts"
    )]
    ContradictoryContacts {
        /// The difference of an equation whose coefficients have length one.
        residual: f64,
    },
    /// The quadratic program of a level did not end; rounding exceeds its tolerances.
    #[error("the quadratic program did not end in {steps} steps: the weights differ by too many orders")]
    NotConverged {
        /// The number of steps.
        steps: usize,
    },
}

impl Classified for WholeBodyError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Controller(error) => error.kind(),
            Self::Infeasible { .. } | Self::ContradictoryContacts { .. } => ErrorKind::Infeasible,
            Self::NotConverged { .. } => ErrorKind::NotConverged,
        }
    }
}

impl From<InvalidInput> for WholeBodyError {
    fn from(error: InvalidInput) -> Self {
        Self::Controller(error.into())
    }
}

impl From<WholeBodyError> for ControllerError {
    /// Keeps a [`ControllerError`]; others become its `Callback` with the original inside.
    fn from(error: WholeBodyError) -> Self {
        match error {
            WholeBodyError::Controller(error) => error,
            error => Self::Callback(CallbackError::new(error)),
        }
    }
}
