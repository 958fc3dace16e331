//! Reads and writes URDF robot files, and reads SDF models and SRDF files.
//!
//! [`load`] and [`parse`] turn the text of a URDF file into a
//! [`robot_dynamics_description::RobotDescription`] and a [`LoadReport`], which lists, by line, everything
//! that was read, defaulted and ignored. A file without a meaning in the equations of motion is refused with
//! a [`LoadError`] that lists all of its errors. Suspicious values are taken as written, with a warning in
//! the report ([`Severity`]). Mesh files are not opened. [`write()`] writes a robot as URDF. [`load`] and
//! [`parse`] also read the model of an SDF file. [`add_srdf`] adds an SRDF file to a robot.
//!
//! ```
//! let robot = robot_dynamics_urdf::parse(
//!     r#"<robot name="pendulum">
//!          <link name="ceiling"/>
//!          <link name="bob">
//!            <inertial>
//!              <origin xyz="0 0 -1"/>
//!              <mass value="2"/>
//!              <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>
//!            </inertial>
//!          </link>
//!          <joint name="hinge" type="continuous">
//!            <parent link="ceiling"/>
//!            <child link="bob"/>
//!            <axis xyz="0 1 0"/>
//!            <dynamics damping="0.1"/>
//!          </joint>
//!        </robot>"#,
//!     &robot_dynamics_urdf::LoadOptions::default(),
//! )?;
//! assert_eq!(robot.description.joints[0].passive.damping, 0.1);
//! assert_eq!(robot.report.counts.degrees_of_freedom, 1);
//! assert_eq!(robot.report.counts.ignored_physics, 0);
//! # Ok::<(), robot_dynamics_urdf::LoadError>(())
//! ```

// Entry points and errors.
mod error;
mod load;
mod robot;

// XML elements, and the report of everything that is not read.
mod attribute;
mod drake;
mod element;
mod reader;
mod unread_parts;
mod xacro;

// One URDF element per file.
mod inertial;
mod joint;
mod joint_dynamics;
mod limit;
mod material;
mod mesh_file;
mod mimic;
mod origin;
mod shapes;

// Checks of the robot as a whole.
mod mass_check;
mod mimic_leaders;
mod rigid_body;
mod tree;
mod world;

// The writer.
mod writer;

// SRDF: groups, poses, and pairs of links without collisions.
mod srdf;

// SDF models.
mod sdf;

pub use error::{LoadError, UrdfError};
pub use load::{load, parse, parse_as, parse_with_files};
pub use robot::Robot;
pub use robot_dynamics_description::{Disposition, Finding, LoadCounts, LoadReport, Severity};
pub use robot_dynamics_xml::{LoadOptions, SIZE_LIMIT, Srdf};
pub use srdf::{add_srdf, disabled_collisions, load_disabled_collisions};
pub use writer::write;
