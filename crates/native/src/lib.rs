//! Machine code in memory from an expression, without a compiler.
//!
//! A graph of operations, traced by [`expression`], becomes straight-line code for the processor at hand:
//!
//! 1. The graph becomes a list of operations that the processor has; sines become the library's polynomials.
//! 2. Values get registers. Where there are too few, the value that is read again last is stored in scratch memory of the caller.
//! 3. Instructions become bytes, with their constants behind them.
//! 4. The bytes are written into a page of memory, which is made executable.
//! 5. The code is compared with its graph in two random states.
//!
//! The results have the bits of the graph's operations done one by one, as those of generated C and Rust have.

// Errors, and what code is made for,
mod error;
mod target;

// operations of a list,
mod list;
mod pool;

// from the graph,
mod lower;
mod prelude;
mod rows;
mod sine;

// with registers,
mod allocate;
mod instruction;
mod machine;

// as bytes,
mod arm;
mod code;
mod x86;

// which are run and checked.
mod check;
mod kernel;
mod page;

pub use code::{Code, Statistics};
pub use error::CompileError;
pub use kernel::{AngleOutOfRange, Float, Kernel};
pub use target::{Target, Width, best_instructions};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
