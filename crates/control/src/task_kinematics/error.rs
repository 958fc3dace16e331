//! Errors of inverse kinematics with tasks.

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use super::solution::{KinematicLimit, TaskResidual, TaskSolution};

/// The error of [`TaskKinematics`](super::TaskKinematics).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TaskKinematicsError {
    /// A configuration, a target, a weight or a limit is invalid, or a result overflows.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// No velocity satisfies the limits together.
    #[error(
        "no velocity satisfies all limits: {limit} contradicts the others; relax it, or take a longer step"
    )]
    Infeasible {
        /// The limit at which the contradiction was found.
        limit: KinematicLimit,
    },
    /// The quadratic program of a level did not end; rounding exceeds its tolerances.
    #[error("the quadratic program did not end in {steps} steps: the weights differ by too many orders")]
    NotConverged {
        /// The number of steps.
        steps: usize,
    },
    /// No start led to a configuration in which all tasks of the first level are within the tolerances.
    #[error("robot `{robot}` did not reach its targets in {iterations} steps from the start and {restarts} random ones: {}{}",
        .unreached.join("; "), limits_in_words(.limits))]
    Unreached {
        /// The name of the robot.
        robot: String,
        /// The tasks that are beyond the tolerances, in words, with their errors.
        unreached: Vec<String>,
        /// The names of the coordinates at their position limits in the nearest configuration.
        limits: Vec<String>,
        /// The number of steps from all starts.
        iterations: usize,
        /// The number of random starts.
        restarts: usize,
        /// The nearest configuration found.
        best: Box<TaskSolution>,
    },
}

fn limits_in_words(limits: &[String]) -> String {
    if limits.is_empty() {
        return "; no coordinate is at its limit".to_owned();
    }
    format!("; at their limits: {}", limits.join(", "))
}

/// A task beyond the tolerances, in words.
pub(super) fn unreached(task: &str, error: TaskResidual) -> String {
    format!("{task} is off by {:e} m and {:e} rad", error.position, error.angle)
}

impl Classified for TaskKinematicsError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Infeasible { .. } => ErrorKind::Infeasible,
            Self::NotConverged { .. } | Self::Unreached { .. } => ErrorKind::NotConverged,
        }
    }
}
