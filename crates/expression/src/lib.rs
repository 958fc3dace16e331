//! What an algorithm computes, written down as an expression.
//!
//! An algorithm that is generic over its number, run over [`Traced`], leaves a [`Graph`] of operations: each once, constants folded, zeros
//! gone. Expressions are simplified as they are written, differentiated by the chain rule, brought into an [order](Plan), and
//! [computed](interpret) with a bound of what rounding does to them; as programs in some language they are written elsewhere.
//!
//! ```
//! use expression::{Arithmetic, evaluate, trace};
//! use number::Scalar;
//!
//! fn hypotenuse<S: Scalar>(x: S, y: S) -> S {
//!     (x * x + y * y).sqrt()
//! }
//! let (graph, _) = trace(Arithmetic::default(), &[1, 1], |x| vec![vec![hypotenuse(x[0][0], x[1][0])]]);
//! assert_eq!(graph.nodes.len(), 6); // x, y, two products, a sum and a root
//! let known = evaluate(Arithmetic::default(), &[vec![3.0], vec![4.0]], |x| vec![vec![hypotenuse(x[0][0], x[1][0])]]);
//! assert_eq!(known, [[5.0]]);
//! ```

// How an expression is computed,
mod arithmetic;
mod precision;

// the operations, and which of them need not be done,
mod graph;
mod hash;
mod rules;

// the number that writes them down,
mod traced;
mod triple;

// their slopes,
pub mod chain;

// in which order they are done, and what rounding does.
mod plan;
mod rounding;

pub use arithmetic::{Arithmetic, Sine};
pub use graph::{Graph, Operand, Operation};
pub use plan::{Plan, as_traced, most_live};
pub use precision::Precision;
pub use rounding::interpret;
pub use traced::{Traced, continue_trace, evaluate, trace, trace_sine, trace_sine_of_quarters};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
