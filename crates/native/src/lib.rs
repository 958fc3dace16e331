//! Machine code in memory from an expression, without a compiler.
//!
//! A graph of operations, traced by [`robot_dynamics_expression`], becomes straight-line code for this
//! processor:
//!
//! 1. Instruction selection: the graph becomes a list of operations that the processor has, and sines become
//!    the library's polynomials.
//! 2. Register allocation: values get registers. Where there are too few, the value whose next use is
//!    farthest is spilled to scratch memory of the caller.
//! 3. Encoding: instructions become bytes, followed by their constants.
//! 4. Loading: the bytes are written into a page of memory, which is then made executable.
//! 5. Self-check: the code is compared with its graph in two random states.
//!
//! The results have the same bits as the graph's operations done one by one, and as generated C and Rust.

// Errors and targets,
mod error;
mod target;

// the list of operations,
mod list;
mod pool;

// instruction selection,
mod lowering;
mod prelude;
mod rows;
mod sine;

// register allocation,
mod allocation;
mod instruction;
mod machine;

// encoding,
mod arm;
mod code;
mod x86;

// and execution.
mod check;
mod float;
mod kernel;
mod page;

pub use code::{Code, Statistics};
pub use error::CompileError;
pub use float::Float;
pub use kernel::{AngleOutOfRange, Kernel};
pub use target::{Target, Width, best_instructions};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
