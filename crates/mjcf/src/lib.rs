//! Reads and writes MJCF robot files, the format of MuJoCo.
//!
//! [`load`], [`load_from_files`] and [`parse`] turn an MJCF file and the files that it includes or attaches
//! into a [`robot_dynamics_description::RobotDescription`] and a [`LoadReport`], which lists, by line,
//! everything that was read, defaulted and ignored. A file without a meaning in the equations of motion is
//! refused with a [`LoadError`] that lists all of its errors. Suspicious values are taken as written, with a
//! warning in the report ([`Severity`]). A mesh file is opened only if the inertia of a body comes from it.
//! [`write()`] writes a robot as MJCF.
//!
//! ```
//! let robot = robot_dynamics_mjcf::parse(
//!     r#"<mujoco model="pendulum">
//!          <compiler angle="radian"/>
//!          <worldbody>
//!            <body name="bob">
//!              <joint name="hinge" axis="0 1 0" damping="0.1"/>
//!              <geom type="capsule" fromto="0 0 0  0 0 -1" size="0.02" mass="2"/>
//!            </body>
//!          </worldbody>
//!        </mujoco>"#,
//!     &robot_dynamics_mjcf::LoadOptions::default(),
//! )?;
//! assert_eq!(robot.description.joints[0].passive.damping, 0.1);
//! assert_eq!(robot.description.links[1].mass_properties.map(|bob| bob.mass()), Some(2.0));
//! assert_eq!(robot.report.counts.degrees_of_freedom, 1);
//! # Ok::<(), robot_dynamics_mjcf::LoadError>(())
//! ```

// Entry points and errors.
mod error;
mod load;

// XML: one tree of all files, and the report of everything that is not read.
mod attachment;
mod attribute;
mod element;
mod floating_base;
mod folder;
mod frame_scale;
mod grammar;
mod path;
mod reader;
mod renaming;
mod source;
mod tree;
mod unread_parts;

// Settings and defaults.
mod classes;
mod compiler;
mod defaults;
mod option;
mod settings;

// Bodies and their content.
mod body;
mod builtin_mesh;
mod fluid;
mod geom;
mod inertial;
mod joint;
mod orientation;
mod worldbody;

// Inertia from shapes.
mod assets;
mod mesh;
mod mesh_mass;
mod primitive;

// The robot as a whole.
mod alignment;
mod assembly;
mod mass;
mod names;
mod principal_axes;
mod simple_slides;

// Actuators, sensors, constraints, keyframes and shapes.
mod actuator;
mod contact;
mod damping_ratios;
mod equality;
mod keyframe;
mod motor;
mod sensor;
mod shapes;
mod tendon;

// The writer.
mod writer;

pub use error::{LoadError, MjcfError};
pub use folder::FileSet;
pub use load::{Robot, load, load_from_files, parse, parse_as};
pub use robot_dynamics_description::{Disposition, Finding, LoadCounts, LoadReport, Severity};
pub use robot_dynamics_xml::{LoadOptions, SIZE_LIMIT};
pub use writer::write;
