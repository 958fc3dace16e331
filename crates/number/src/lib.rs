//! Numbers that the formulas of dynamics are written over.
//!
//! A mass matrix written once over [`Scalar`] yields its value (`f64`, `f32`) or its exact derivatives
//! ([`Dual`]). Where a machine has the registers for it, it yields the values of several states at once.
//!
//! # Numbers that only some machines have
//!
//! A program is compiled for the oldest machine of its kind. Newer machines have more: a multiply-add that
//! rounds once, registers of four or eight numbers. Such numbers are reached through [`dispatch`] alone. An
//! algorithm is written as a kernel, and the kernel runs over a number of the machine's own once its
//! instructions have been detected. Those numbers have no public names, and no public type leads to one, so
//! safe code cannot execute an instruction that the machine lacks.
//!
//! All of the library's `unsafe` code for instructions is in this crate. `registers` has a file for each
//! instruction set. `fused_slices` reads a slice of floats as a slice of the machine's numbers. `cache`
//! prefetches memory. `dispatch` and `float` call code that is compiled for an instruction set after it was
//! detected. A WebAssembly module cannot detect instructions: it is built with simd128 or without, and an
//! engine that lacks simd128 rejects the module.

// The operations of a number,
mod arrays;
mod scalar;
mod triple;

// three-vectors and 3×3 matrices of it,
#[doc(hidden)]
pub mod algebra;

// exact derivatives,
mod dual;

// hardware floats, alone or several states side by side,
mod float;
mod state_lanes;
mod view;

// prefetch hints,
#[doc(hidden)]
pub mod cache;

// the numbers of each instruction set,
#[cfg(registers)]
mod fma_float;
#[cfg(registers)]
mod fma_slices;
mod instruction_set;
#[cfg(registers)]
mod quad;
#[cfg(registers)]
mod registers;

// the project's own sine, for registers and for generated programs,
#[doc(hidden)]
pub mod sine;

// and the dispatch to them.
pub mod dispatch;

// The seeded generator of test states.
mod random;

// Invalid numbers, and the kinds of all errors.
mod error_kind;
mod invalid_input;

pub use dual::Dual;
pub use error_kind::{Classified, ErrorKind};
pub use float::Float;
pub use instruction_set::InstructionSet;
pub use invalid_input::{
    InputProblem, InvalidInput, are_finite, check_finite, check_number, check_positive, check_result,
};
pub use random::SplitMix64;
pub use scalar::Scalar;
#[doc(hidden)]
pub use scalar::{Specialization, TypeFamily};
#[doc(hidden)]
pub use state_lanes::StateLanes;
#[doc(hidden)]
pub use triple::{Symmetric, Triple};
#[doc(hidden)]
pub use view::View;
