//! Why nothing was generated.

use std::path::PathBuf;

use functions::FunctionError;
use thiserror::Error;

/// Why nothing was generated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// The robot does not have the function.
    #[error(transparent)]
    Function(#[from] FunctionError),
    /// The same name would be given to two functions.
    #[error(
        "two functions would be called `{symbol}`: ask for each function once, and of frames whose names differ in letters or digits"
    )]
    SameName {
        /// The name.
        symbol: String,
    },
    /// The robot has nothing that moves.
    #[error("robot `{robot}` has no moving joint: there is nothing to generate")]
    Motionless {
        /// Its name.
        robot: String,
    },
    /// A value is infinite or none.
    #[error("`{function}` of robot `{robot}` is not finite in random states of it: see `dynamics audit`")]
    NotFinite {
        /// The robot's name.
        robot: String,
        /// The function's name.
        function: String,
    },
    /// The generated slopes are not the library's.
    #[error(
        "`{function}` of robot `{robot}` is further from the library's than rounding can bring it: a fault of this program, please report it"
    )]
    Differs {
        /// The robot's name.
        robot: String,
        /// The function's name.
        function: String,
    },
    /// The target has no such numbers.
    #[error("{target} has no {what}: {remedy}")]
    NotInTarget {
        /// The target's name.
        target: &'static str,
        /// What it lacks.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A program that measuring needs is missing or fails.
    #[error("`{program}`: {what}: measuring needs a compiler that works, generating does not")]
    Compiler {
        /// The program.
        program: String,
        /// What it or the system says.
        what: String,
    },
    /// The robot's file was refused.
    #[error(transparent)]
    Robot(#[from] robot_dynamics::LoadError),
    /// There is no folder for a build script's output.
    #[error("the variable OUT_DIR is not set: call this in a build script")]
    NoOutput,
    /// A file is there that no generator wrote.
    #[error("`{}` is there and was not generated: move it, or choose another folder", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// A file could not be read or written.
    #[error("`{}`: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
}
