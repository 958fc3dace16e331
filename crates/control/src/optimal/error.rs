//! Errors of problems and solvers.

use core::fmt;

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use robot_dynamics_simulation::StepError;
use thiserror::Error;

/// The function of a node that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Evaluation {
    /// f(x, u).
    Dynamics,
    /// The derivatives A and B of f.
    Linearization,
    /// The cost or its derivatives.
    Cost,
    /// A constraint or its derivatives.
    Constraint,
}

impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dynamics => "the dynamics",
            Self::Linearization => "the derivatives of the dynamics",
            Self::Cost => "the cost",
            Self::Constraint => "a constraint",
        })
    }
}

/// An error of a [`Problem`](super::Problem) or of its solution.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OptimalControlError {
    /// An argument is invalid, or parts of the problem do not fit together.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// A function of a node failed at the given or initial trajectory.
    #[error("node {node}: {evaluation} cannot be computed: {cause}")]
    Node {
        /// The index of the node; N is the terminal node.
        node: usize,
        /// The function.
        evaluation: Evaluation,
        /// The cause.
        #[source]
        cause: StepError,
    },
}

impl Classified for OptimalControlError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Node { cause, .. } => cause.kind(),
        }
    }
}
