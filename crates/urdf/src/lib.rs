//! URDF robot files, read without losing physics.
//!
//! [`load`] and [`parse`] turn the text of a URDF file into a [`multibody::RobotDescription`] and a
//! [`LoadReport`] that lists, by line, everything that was read, defaulted and ignored. What has no meaning in the
//! equations of motion is refused, with all such places in one [`LoadError`]; what is only suspicious is taken as
//! written, with a warning in the report ([`Severity`]). Meshes are never opened. [`write()`] is the way back.
//!
//! ```
//! let robot = urdf::parse(
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
//!     &urdf::Options::default(),
//! )?;
//! assert_eq!(robot.description.joints[0].passive.damping, 0.1);
//! assert_eq!(robot.report.counts.degrees_of_freedom, 1);
//! assert_eq!(robot.report.counts.ignored_physics, 0);
//! # Ok::<(), urdf::LoadError>(())
//! ```

// What goes in and what comes out.
mod error;
mod load;

// The XML: walked with every line and every unread thing accounted for.
mod element;
mod reader;
mod unread;
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

// What must hold for the robot as a whole.
mod following;
mod moved_mass;
mod rigid_body;
mod tree;
mod world;

// The way back: from a robot to a file.
mod write;

// Beside the robot: which links never touch.
mod srdf;

pub use error::{LoadError, UrdfError};
pub use load::{Robot, load, parse, parse_as};
pub use multibody::{Counts, Finding, LoadReport, Severity, Treatment};
pub use robot_xml::{Options, SIZE_LIMIT};
pub use srdf::{SrdfError, disabled_collisions, load_disabled_collisions};
pub use write::write;
