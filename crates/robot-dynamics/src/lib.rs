//! The dynamics of any robot from its file: M(q) v̇ + C(q,v) v + g(q) + b = τ.
//!
//! ```
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
//! let robot = robot_dynamics::load(file)?;
//! let model = &robot.model;
//! let (q, rest) = (robot_dynamics::neutral(model), vec![0.0; model.nv()]);
//! let hold = model.inverse_dynamics(&q, &rest, &rest)?; // the torques that hold it still
//! assert_eq!(hold, model.gravity_forces(&q)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! | --- | --- |
//! | a robot from its file, of whichever format | [`load`], [`load_with`], [`describe`], [`describe_text`], [`describe_among`] |
//! | a robot's file from a robot, in either format | [`write()`], [`Format`] |
//! | files that replace none that was read, all of them or none | [`output`] |
//! | any robot: recursions, derivatives, kinematics, constraints, control, simulation, batches | everything of [`multibody`], at the top of this crate |
//! | a simulation: everything that the file states, step by step | [`Robot::simulation`], [`simulator`] |
//! | a robot made in code, with its functions in machine code as a loaded robot has them | `with_native_code` |
//! | the points of a shape's mesh file, for contact | [`mesh_corners`] |
//! | the height field of a shape, for contact | [`height_field`] |
//! | states and results as lines of JSON, with the feature `json` | `json` |
//! | the equations of a textbook chapter, in closed form and by the Lagrange recipe | [`dynamics`] |
//! | the readers of each format, with their own reports | [`urdf`], [`mjcf`] |
//! | the linear algebra at the interface | [`nalgebra`] |

mod height_field;
#[cfg(feature = "json")]
pub mod json;
mod load;
mod mesh;
pub mod output;
mod write;

pub use dynamics;
pub use mjcf;
pub use multibody;
pub use nalgebra;
pub use urdf;

#[cfg(feature = "native")]
pub use functions::with_native_code;
pub use height_field::height_field;
pub use load::{
    Described, FileError, LoadError, Robot, describe, describe_among, describe_text, load, load_with,
    simulation,
};
pub use mesh::mesh_corners;
pub use mjcf::FileSet;
pub use multibody::*;
pub use urdf::Options;
pub use write::{Format, write};

/// The code of the repository's front page, compiled and run with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}
