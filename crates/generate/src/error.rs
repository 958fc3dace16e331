//! Errors of code generation.

use std::path::PathBuf;

use robot_dynamics_functions::FunctionError;
use robot_dynamics_number::{Classified, ErrorKind};
use thiserror::Error;

/// The error of [`generate`](crate::generate()) and of the writing and measuring of generated programs.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// The robot does not have the function.
    #[error(transparent)]
    Function(#[from] FunctionError),
    /// Two functions have the same name.
    #[error(
        "two functions have the name `{symbol}`: request each function once, and frames whose names differ in letters or digits"
    )]
    SameName {
        /// The name.
        symbol: String,
    },
    /// The robot has no moving joint.
    #[error("robot `{robot}` has no moving joint, so there is no function to generate")]
    Motionless {
        /// Its name.
        robot: String,
    },
    /// A value is not finite.
    #[error(
        "`{function}` of robot `{robot}` is not finite in random states: run `dynamics audit` on the robot"
    )]
    NotFinite {
        /// The robot's name.
        robot: String,
        /// The function's name.
        function: String,
    },
    /// The generated derivatives differ from the library's.
    #[error(
        "`{function}` of robot `{robot}` differs from the library's values by more than rounding; please report this bug"
    )]
    Differs {
        /// The robot's name.
        robot: String,
        /// The function's name.
        function: String,
    },
    /// The target does not support the request.
    #[error("{target} does not support {what}: {remedy}")]
    NotInTarget {
        /// The target's name.
        target: &'static str,
        /// The unsupported feature.
        what: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// A program that measuring needs is missing or fails.
    #[error("`{program}`: {what}; measuring needs a working compiler, generating does not")]
    Compiler {
        /// The program.
        program: String,
        /// The message of the program or the system.
        what: String,
    },
    /// The robot's file is invalid.
    #[error(transparent)]
    Robot(#[from] robot_dynamics::FileError),
    /// The variable with the folder for a build script's output is not set.
    #[error("the environment variable OUT_DIR is not set: call this from a build script")]
    NoOutput,
    /// A file with the same name exists and was not generated.
    #[error("`{}` exists and was not generated: move it, or choose another folder", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// A file could not be read or written.
    #[error("`{}`: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: std::io::Error,
    },
}

impl Classified for GenerateError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Function(error) => error.kind(),
            Self::Robot(error) => error.kind(),
            Self::SameName { .. } => ErrorKind::InvalidInput,
            Self::Motionless { .. } | Self::NotFinite { .. } => ErrorKind::Description,
            Self::NotInTarget { .. } => ErrorKind::Unsupported,
            Self::Differs { .. } | Self::Compiler { .. } | Self::NoOutput => ErrorKind::System,
            Self::Foreign { .. } | Self::File { .. } => ErrorKind::File,
        }
    }
}
