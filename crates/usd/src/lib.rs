//! Reads robots from USD files: text, binary and archives.
//!
//! 1. `stage` opens the file and all that it references, and copies the composed prims.
//! 2. `geometry` gives each prim its pose and its body; `joint`, `shape` and `mass` read the physics.
//! 3. `tree` chooses the joints of the tree; `assembly` makes links and joints, and `closure` the loops.
//!
//! ```
//! let text = r#"#usda 1.0
//! (
//!     metersPerUnit = 1
//!     upAxis = "Z"
//! )
//! def Xform "bob" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
//! {
//!     float physics:mass = 2
//!     point3f physics:centerOfMass = (0, 0, -1)
//!     float3 physics:diagonalInertia = (0.1, 0.1, 0.1)
//! }
//! def PhysicsRevoluteJoint "hinge"
//! {
//!     uniform token physics:axis = "Y"
//!     rel physics:body1 = </bob>
//! }
//! "#;
//! let robot = robot_dynamics_usd::parse_as(text.as_bytes(), "bob.usda", &robot_dynamics_usd::LoadOptions::default())?;
//! assert_eq!(robot.description.joints[0].name, "hinge");
//! assert_eq!(robot.report.counts.degrees_of_freedom, 1);
//! # Ok::<(), robot_dynamics_usd::LoadError>(())
//! ```

// Entry points and errors.
mod error;
mod findings;
mod load;
mod read;

// The file.
mod binary;
mod path_table;
mod paths;
mod prim;
mod resolver;
mod scan;
mod stage;
mod value;

// Physics.
mod actuator;
mod collider;
mod drive;
mod geometry;
mod joint;
mod mass;
mod mass_check;
mod names;
mod shape;
mod transform;
mod unread;

// The robot.
mod assembly;
mod closure;
mod tree;

pub use error::{LoadError, UsdError};
pub use load::{load, parse_as, parse_with_files};
pub use read::Robot;
pub use robot_dynamics_description::{Disposition, Finding, LoadCounts, LoadReport, Severity};
pub use robot_dynamics_xml::LoadOptions;
pub use scan::is_usd;
