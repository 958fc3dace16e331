//! Errors of compilation to machine code.

use robot_dynamics_number::{Classified, ErrorKind, InstructionSet};

/// The reason why a graph was not compiled: the error of the constructors of [`Kernel`](crate::Kernel).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompileError {
    /// This crate has no encoder for these instructions.
    #[error("no encoder for {instructions:?} instructions; use the library's recursions")]
    NoEncoder {
        /// The requested instructions.
        instructions: InstructionSet,
    },
    /// This processor cannot run the code.
    #[error(
        "this processor does not support {instructions:?} instructions; use those of `best_instructions`"
    )]
    NotOnThisProcessor {
        /// The requested instructions.
        instructions: InstructionSet,
    },
    /// The graph was traced in another precision than the kernel's numbers have.
    #[error("the graph is in {found}, but the kernel computes in {expected}; trace the graph in {expected}")]
    Precision {
        /// The graph's precision.
        found: robot_dynamics_expression::Precision,
        /// The precision of the kernel's numbers.
        expected: robot_dynamics_expression::Precision,
    },
    /// The graph uses the platform's sine.
    #[error("the graph uses the platform's sine, which machine code cannot call; trace it with `Sine::Own`")]
    PlatformSine,
    /// An argument is shorter than the graph requires.
    #[error("the graph reads number {index} of argument {argument}, which has a length of {length}")]
    Argument {
        /// The number of the argument.
        argument: usize,
        /// The number that the graph reads.
        index: usize,
        /// The length of the argument.
        length: usize,
    },
    /// The number of arguments and results exceeds the limit of a kernel.
    #[error("the graph has {count} arguments and results, but a kernel supports at most {most}")]
    TooManyTables {
        /// Arguments and results together.
        count: usize,
        /// The limit of a kernel.
        most: usize,
    },
    /// The code would be larger than its addresses reach.
    #[error(
        "the graph has {operations} operations, too many for the 32-bit addresses of its code; compile smaller parts"
    )]
    TooLarge {
        /// Operations of the graph.
        operations: usize,
    },
    /// The operating system refused executable memory.
    #[error("the operating system refused to make memory executable: {cause}")]
    Refused {
        /// The system's error.
        cause: std::io::Error,
    },
    /// The results of the code differ from those of the graph.
    #[error(
        "number {index} of result {result} is {found:e} by machine code, but {expected:e} by the graph; please report this robot, and use the library's recursions"
    )]
    Differs {
        /// The number of the result.
        result: usize,
        /// The number within it.
        index: usize,
        /// The value by machine code.
        found: f64,
        /// The value by the graph.
        expected: f64,
    },
}

impl Classified for CompileError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NotOnThisProcessor { .. } | Self::Refused { .. } | Self::Differs { .. } => {
                ErrorKind::System
            }
            _ => ErrorKind::Unsupported,
        }
    }
}
