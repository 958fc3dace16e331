//! Errors of functions that a robot does not have.

use robot_dynamics_core::SingularMass;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::Function;

/// The reason why a robot does not have a function: the error of parsing a [`Function`] and of tracing it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FunctionError {
    /// No function has this name.
    #[error("unknown function `{name}`; the functions are {}; of a frame {}; and for each except derivatives and pullbacks, NAME_derivatives and NAME_pullback", plain_names(), Function::OF_FRAMES.map(|name| format!("{name}:FRAME")).join(", "))]
    Unknown {
        /// The name given.
        name: String,
    },
    /// Derivatives or pullbacks of derivatives or pullbacks.
    #[error(
        "unknown function `{function}`: derivatives and pullbacks have no derivatives or pullbacks themselves"
    )]
    NotDifferentiable {
        /// The function's name.
        function: String,
    },
    /// A step with contact is differentiated in stages, which this language does not have.
    #[error(
        "`{function}` is computed in stages: generate it for CUDA or WGSL, where it is one kernel, or generate its stages"
    )]
    InStages {
        /// The function's name.
        function: String,
    },
    /// The robot has no such frame.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// A function that inverts M has no value where M is singular.
    #[error("robot `{robot}` has no `{function}`: {cause}")]
    Singular {
        /// The robot's name.
        robot: String,
        /// The function's name.
        function: String,
        /// The motions that move no inertia.
        cause: SingularMass,
    },
}

impl Classified for FunctionError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Unknown { .. } | Self::NotDifferentiable { .. } => ErrorKind::UnknownName,
            Self::InStages { .. } => ErrorKind::Unsupported,
            Self::Input(error) => error.kind(),
            Self::Singular { .. } => ErrorKind::Singular,
        }
    }
}

fn plain_names() -> String {
    let all = Function::PLAIN.into_iter().chain(Function::OF_CONTACT);
    all.map(|function| function.to_string()).collect::<Vec<_>>().join(", ")
}
