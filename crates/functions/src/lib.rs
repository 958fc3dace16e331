//! Functions of one robot as expressions.
//!
//! A [`Function`] has a name, arguments and results. [`Function::trace`] runs the library's recursions over
//! the number that records expressions. The traced model has exact right angles. Where only the equation of
//! motion matters, its mass is regrouped to the body that it moves with. Code in other languages and machine
//! code made from the graph have the same bits.
//!
//! ```
//! use robot_dynamics::description::pendulum;
//! use robot_dynamics::model::Model;
//! use robot_dynamics_expression::Arithmetic;
//! use robot_dynamics_functions::Function;
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

// the expressions and their derivatives,
mod derivatives;
mod traced_function;

// and their machine code.
mod native_code;

pub use call::FunctionMemory;
pub use error::FunctionError;
pub use function::{Argument, Function, FunctionResult};
pub use name::identifier;
pub use native_code::with_native_code;
pub use table::Table;
pub use traced_function::{LEAST_EQUAL_LINKS, TracedFunction};

#[cfg(test)]
mod testing;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
