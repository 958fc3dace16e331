//! Errors of rollouts.

use robot_dynamics_integrators::Integrator;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use robot_dynamics_simulation::motion::integrate::explicit::explicit_names;
use thiserror::Error;

use crate::BadStates;

/// The error of [`rollout`](crate::rollout) and of its pullback: an invalid argument, or states that did not
/// reach the end.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RolloutError {
    /// Some states became invalid; all others are valid.
    #[error(transparent)]
    BadStates(#[from] BadStates),
    /// The progress callback cancelled the rollout.
    #[error("the rollout was cancelled: {} of {batch} states are as they were", .unfinished.len())]
    Cancelled {
        /// The indices of the unchanged states, ascending; all others are at the end of the rollout.
        unfinished: Vec<usize>,
        /// The number of states in the batch.
        batch: usize,
    },
    /// The step is not positive and finite.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The row solves an equation in each step.
    #[error(
        "{integrator} solves an equation at each step; batches move by explicit rows: {}",
        explicit_names()
    )]
    Implicit {
        /// The requested row.
        integrator: Integrator,
    },
    /// A policy gives the torques of a rollout whose pullback is requested.
    #[error(
        "a policy's torques depend on the state in a way that is not known here: keep the torques it gave, pull the \
         rollout back with `Torques::EachStep`, and add what the policy's own derivatives make of `by_force`"
    )]
    Policy,
}

impl Classified for RolloutError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::BadStates(error) => error.kind(),
            Self::Cancelled { .. } => ErrorKind::Interrupted,
            Self::Input(error) => error.kind(),
            Self::Implicit { .. } | Self::Policy => ErrorKind::Unsupported,
        }
    }
}
