//! MJCF robot files, the format of MuJoCo, read without losing physics.
//!
//! [`load`], [`load_among`] and [`parse`] turn an MJCF file, with the files that it includes, into a [`multibody::RobotDescription`] and a
//! [`LoadReport`] that lists, by line, everything that was read, defaulted and ignored. What has no meaning in the
//! equations of motion is refused, with all such places in one [`LoadError`]; what is only suspicious is taken as
//! written, with a warning in the report ([`Severity`]). Mesh files are opened only where a body's inertia is to be
//! inferred from them. [`write()`] is the way back.
//!
//! ```
//! let robot = mjcf::parse(
//!     r#"<mujoco model="pendulum">
//!          <compiler angle="radian"/>
//!          <worldbody>
//!            <body name="bob">
//!              <joint name="hinge" axis="0 1 0" damping="0.1"/>
//!              <geom type="capsule" fromto="0 0 0  0 0 -1" size="0.02" mass="2"/>
//!            </body>
//!          </worldbody>
//!        </mujoco>"#,
//!     &mjcf::Options::default(),
//! )?;
//! assert_eq!(robot.description.joints[0].passive.damping, 0.1);
//! assert_eq!(robot.description.links[1].mass_properties.map(|bob| bob.mass()), Some(2.0));
//! assert_eq!(robot.report.counts.degrees_of_freedom, 1);
//! # Ok::<(), mjcf::LoadError>(())
//! ```

// What goes in and what comes out.
mod error;
mod load;

// The XML: one tree of all included files, walked with every line and every unread thing accounted for.
mod attach;
mod attribute;
mod floating_base;
mod folder;
mod grammar;
mod reader;
mod renaming;
mod source;
mod tree;
mod unread;

// What the file says of itself.
mod classes;
mod compiler;
mod option;

// Bodies and what is in them.
mod body;
mod geom;
mod inertial;
mod joint;
mod orientation;
mod walk;

// Inertia from shapes.
mod mesh;
mod mesh_mass;
mod primitive;

// The robot as a whole.
mod align;
mod assemble;
mod mass;
mod names;
mod simple_slides;

// What stands beside the tree.
mod actuator;
mod contact;
mod derived;
mod equality;
mod keyframe;
mod motor;
mod sensor;
mod shapes;
mod tendon;

// The way back: from a robot to a file.
mod write;

pub use error::{LoadError, MjcfError};
pub use folder::FileSet;
pub use load::{Robot, load, load_among, parse, parse_as};
pub use multibody::{Counts, Finding, LoadReport, Severity, Treatment};
pub use robot_xml::{Options, SIZE_LIMIT};
pub use write::write;
