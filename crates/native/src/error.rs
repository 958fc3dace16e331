//! Reasons why there is no machine code.

use number::InstructionSet;

/// Why a graph was not compiled.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompileError {
    /// There is no encoder for these instructions.
    #[error("there is no encoder for {instructions:?} instructions; use the library's recursions")]
    NoEncoder {
        /// The instructions that were asked for.
        instructions: InstructionSet,
    },
    /// This processor cannot run the code.
    #[error(
        "not on this processor: it has no {instructions:?} instructions; ask for those of `best_instructions`"
    )]
    NotOnThisProcessor {
        /// The instructions that were asked for.
        instructions: InstructionSet,
    },
    /// The graph was traced in another precision than the kernel's numbers have.
    #[error("the graph is in {found}, the kernel computes in {expected}; trace it in {expected}")]
    Precision {
        /// The graph's precision.
        found: expression::Precision,
        /// The precision of the kernel's numbers.
        expected: expression::Precision,
    },
    /// The platform's sine is not a part of the graph.
    #[error("the graph takes the platform's sine, which machine code cannot call; trace it with `Sine::Own`")]
    PlatformSine,
    /// An argument has another length than the graph reads.
    #[error("the graph reads number {index} of argument {argument}, which has {length} numbers")]
    Argument {
        /// The number of the argument.
        argument: usize,
        /// The number that the graph reads.
        index: usize,
        /// The length that was given.
        length: usize,
    },
    /// There are more arguments and results than a kernel takes.
    #[error("{count} arguments and results; a kernel takes at most {most}")]
    TooManyTables {
        /// Arguments and results together.
        count: usize,
        /// The most that a kernel takes.
        most: usize,
    },
    /// The code would be larger than its addresses reach.
    #[error(
        "the graph needs {operations} operations, and addresses within its code reach 2³¹ bytes; compile smaller parts"
    )]
    TooLarge {
        /// Operations of the graph.
        operations: usize,
    },
    /// The operating system refused memory that can be executed.
    #[error("the operating system refused to make memory executable: {cause}")]
    Refused {
        /// The system's error.
        cause: std::io::Error,
    },
    /// The code computes something else than the graph says.
    #[error(
        "number {index} of result {result} is {found:e} by machine code and {expected:e} by the graph; please report this robot, and use the library's recursions"
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
