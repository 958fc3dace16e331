//! Functions of one robot as expressions.
//!
//! A [`Function`] names what is computed, its arguments and its results. [`Function::trace`] runs the library's recursions over the number that
//! writes expressions: on a model in which mass is counted with the body that it moves with, where only the equation of motion counts, and with
//! right angles made exact. What is made from the graph, code in another language or in memory, has the same bits.
//!
//! ```
//! use expression::Arithmetic;
//! use functions::Function;
//! use multibody::{Model, pendulum};
//! let model = Model::new(pendulum(2.0, 0.5))?;
//! let traced = Function::MassMatrix.trace(&model, Arithmetic::default())?;
//! assert_eq!(traced.results[0][0].known(), Some(0.5)); // m l², whatever q is
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Names, arguments and results,
mod error;
mod function;
mod name;
mod table;

// the library's calls over any number,
mod call;

// the expressions and their slopes,
mod slopes;
mod traced;

// machine code of them.
mod native_code;

pub use call::FunctionMemory;
pub use error::FunctionError;
pub use function::{Argument, Function, Outcome};
pub use name::identifier;
pub use native_code::with_native_code;
pub use table::Table;
pub use traced::{LEAST_EQUAL_LINKS, TracedFunction};

#[cfg(test)]
mod testing;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
