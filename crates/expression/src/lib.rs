//! The computation of an algorithm as an expression.
//!
//! An algorithm that is generic over its number and runs over [`Traced`] produces a [`Graph`] of operations:
//! each once, with constants folded and zeros removed. Expressions are simplified as they are recorded,
//! differentiated by the chain rule, [scheduled](Plan), and [evaluated](interpret) with a bound on their
//! rounding errors. Other crates write them as programs.
//!
//! ```
//! use robot_dynamics_expression::{Arithmetic, evaluate, trace};
//! use robot_dynamics_number::Scalar;
//!
//! fn hypotenuse<S: Scalar>(x: S, y: S) -> S {
//!     (x * x + y * y).sqrt()
//! }
//! let (graph, _) = trace(Arithmetic::default(), &[1, 1], |x| vec![vec![hypotenuse(x[0][0], x[1][0])]]);
//! assert_eq!(graph.nodes.len(), 6); // x, y, two products, a sum and a root
//! let known = evaluate(Arithmetic::default(), &[vec![3.0], vec![4.0]], |x| vec![vec![hypotenuse(x[0][0], x[1][0])]]);
//! assert_eq!(known, [[5.0]]);
//! ```

// The arithmetic of an expression,
mod arithmetic;
mod precision;

// the operations and their simplification,
mod graph;
mod hash;
mod rules;

// the number that records them,
mod scalar;
mod sine;
mod traced;
mod triple;

// their derivatives,
pub mod chain;

// their order, and their rounding errors.
mod plan;
mod rounding;

pub use arithmetic::{Arithmetic, Sine};
pub use graph::{Graph, Operand, Operation};
pub use plan::{Plan, as_traced, most_live};
pub use precision::Precision;
pub use rounding::interpret;
pub use sine::{trace_sine, trace_sine_of_quarters};
pub use traced::{Traced, continue_trace, evaluate, trace};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
