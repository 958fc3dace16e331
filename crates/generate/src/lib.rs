//! A program for one robot: straight-line code from the library's own recursions.
//!
//! The algorithms of `multibody` are generic over their number. Run over one that writes down what is done with it, they leave
//! an expression for this robot alone: its constants folded, its zeros gone, common parts computed once. This crate writes that
//! expression as code without branches, allocation or state, with loops where many bodies are alike, for where the library itself cannot go: microcontrollers,
//! tools for optimal control, graphics processors. It is no second implementation; what it writes is held to the
//! library's values by a test that comes with it.
//!
//! ```
//! use generate::{Function, Request, Target, generate};
//! use multibody::{Model, pendulum};
//! let model = Model::new(pendulum(2.0, 0.5))?; // any robot, mostly from robot_dynamics::load
//! let request = Request::new(Target::C, vec![Function::InverseDynamics, Function::MassMatrix]);
//! let generated = generate(&model, &request)?;
//! let names: Vec<_> = generated.files.iter().map(|file| file.name.as_str()).collect();
//! assert_eq!(names, ["Makefile", "REPORT.md", "pendulum.c", "pendulum.h", "test_pendulum.c"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Traced`] number has no order: no algorithm can branch on a value, as the compiler refuses it; what a branch of the
//! library's depends on is the robot, which is known. The simplifications are those of [`expression`]: each is exact for finite numbers
//! but for the sign of a zero, and nothing is reassociated, so that code in which nothing is fused gives the bits of the library's
//! recursions: on a model in which mass is counted with the body that it moves with, and partly in body frames, so that the
//! library's calls differ by rounding.

// Texts are what this crate makes: of which pieces is read more easily without `write!`.
#![allow(clippy::format_collect, clippy::format_push_string)]

// The names of files and functions,
mod names;

// the functions, with values that they must give,
mod error;
mod program;

// how an expression is written,
mod layout;
mod loops;

// its sparse slopes,
mod jacobian;

// and written.
mod body;
mod builder;
#[cfg(test)]
#[path = "../../functions/src/testing.rs"]
mod free_robot;
mod heading;
mod measure;
mod request;
mod syntax;
mod target;
#[cfg(test)]
mod testing;

pub use builder::Builder;
pub use error::GenerateError;
pub use expression::{Arithmetic, Precision, Sine, Traced};
pub use functions::{Function, FunctionError, Table};
pub use measure::measure;
pub use request::{Generated, GeneratedFile, Request, generate};
pub use target::{Target, WGSL_WORKGROUP};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
