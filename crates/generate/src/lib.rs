//! Programs for one robot: straight-line code from the library's own recursions.
//!
//! The algorithms of `robot_dynamics_core` are generic over their number. Over a number that records the
//! operations, they produce an expression for this robot alone: constants folded, zeros removed, common
//! subexpressions computed once. This crate writes that expression as code without branches, allocation or
//! state, with loops where many bodies are alike. Such code runs where the library cannot: on
//! microcontrollers, in tools for optimal control, on graphics processors. It is not a second implementation:
//! a generated test compares it with the library's values.
//!
//! ```
//! use robot_dynamics::description::pendulum;
//! use robot_dynamics::model::Model;
//! use robot_dynamics_generate::{Function, Request, Target, generate};
//! let model = Model::new(pendulum(2.0, 0.5))?; // any robot, mostly from robot_dynamics::load
//! let request = Request::new(Target::C, vec![Function::InverseDynamics, Function::MassMatrix]);
//! let generated = generate(&model, &request)?;
//! let names: Vec<_> = generated.files.iter().map(|file| file.name.as_str()).collect();
//! assert_eq!(names, ["Makefile", "REPORT.md", "pendulum.c", "pendulum.h", "test_pendulum.c"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Traced`] number cannot be compared, so the compiler rejects an algorithm that branches on a value.
//! Branches of the library depend on the robot alone, which is known when code is generated. The
//! simplifications are those of [`robot_dynamics_expression`]: each is exact for finite numbers except for
//! the sign of a zero, and nothing is reassociated. Code without fused operations therefore has the bits of
//! the library's recursions on the traced model. In this model mass is regrouped to the body that it moves
//! with, and some recursions run in body frames. The library's own calls differ by rounding.

// This crate builds texts, whose parts are easier to read without `write!`.
#![allow(clippy::format_collect, clippy::format_push_string)]

// The names of files and functions,
mod names;

// the functions, with expected values,
mod error;
mod program;

// the layout of an expression,
mod affine_index;
mod layout;
mod loops;

// functions in stages,
mod stage_tables;
mod staged_function;
mod stages;

// their sparse derivatives,
mod jacobian;

// and the text.
mod body;
mod builder;
#[cfg(test)]
#[path = "../../functions/src/testing.rs"]
mod free_robot;
mod generated_files;
mod generation;
mod heading;
mod measure;
mod request;
mod syntax;
mod target;
#[cfg(test)]
mod testing;
mod writers;

pub use builder::Builder;
pub use error::GenerateError;
pub use generated_files::{GeneratedFile, GeneratedFiles};
pub use generation::generate;
pub use measure::measure;
pub use request::Request;
pub use robot_dynamics_expression::{Arithmetic, Precision, Sine, Traced};
pub use robot_dynamics_functions::{Function, FunctionError, Table};
pub use staged_function::{StageExpression, StagedFunction};
pub use target::Target;
pub use writers::WGSL_WORKGROUP;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
