//! What a formula of dynamics is written over.
//!
//! A mass matrix written once over [`Scalar`] yields its value (`f64`, `f32`), its exact derivatives ([`Dual`]), or,
//! where a machine has the registers for it, the values of several states at once.
//!
//! # Numbers that only some machines have
//!
//! A program is built for the oldest machine of its kind. What newer ones can do (a multiply-add that rounds once,
//! registers of four or eight numbers) is met through [`dispatch`] alone: an algorithm is written as a kernel, and the
//! kernel is run over a number of the machine's own once its instructions have been found there. Those numbers have
//! no names outside this crate, and no public type leads to one, so that safe code cannot execute an instruction
//! that the machine lacks.
//!
//! All of the library's `unsafe` code for instructions is in this crate: `registers`, with a file for each instruction
//! set, `view`, which reads a slice of floats as a slice of the machine's numbers, `cache`, which asks for memory before it is
//! needed, and `dispatch` with `float`, which call what is compiled for an instruction set after it was found. A WebAssembly
//! module cannot look: it is built for simd128 or without, and an engine that lacks it refuses the module.

// What a formula needs of its number,
mod scalar;
mod triple;

// exact derivatives,
mod dual;

// hardware floats, alone or several states side by side,
mod float;
mod state_lanes;
mod view;

// what the processor is told of memory,
#[doc(hidden)]
pub mod cache;

// the numbers of each instruction set,
#[cfg(registers)]
mod fused;
mod instruction_set;
#[cfg(registers)]
mod quad;
#[cfg(registers)]
mod registers;

// the project's own sine, for registers and for generated programs,
#[doc(hidden)]
pub mod sine;

// and the way to them.
pub mod dispatch;

// The seeded generator of test states.
mod random;

pub use dual::Dual;
pub use float::Float;
pub use instruction_set::InstructionSet;
pub use random::SplitMix64;
pub use scalar::Scalar;
#[doc(hidden)]
pub use scalar::{AsFloat, Form};
#[doc(hidden)]
pub use state_lanes::StateLanes;
#[doc(hidden)]
pub use triple::{Symmetric, Triple};
#[doc(hidden)]
pub use view::View;
