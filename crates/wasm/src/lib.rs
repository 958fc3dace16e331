//! The lab's face: what a web page may ask of the library, checked at the boundary.
//!
//! Every call that can fail returns a [`LabError`], which JavaScript receives as an `Error` with the same
//! message; a panic would kill the module, so non-finite numbers and wrong lengths are refused here. Vectors
//! cross as plain lists of numbers, matrices row by row. Nothing is computed here that the library can
//! compute: these types hold a state, count steps, and keep samples for the plots.
//!
//! The feature `chapter` holds the experiments of the chapter, `flips` the map of first flips, `robots` the robots from
//! files: modules of their own, so that the page opens with the first and fetches the others when someone comes to them.
//! The last two are built twice, with vector registers (simd128) and without.
//!
//! The same code runs natively, which is how it is tested; [`parity_values`] and [`robot_parity_values`] list the
//! numbers that all builds must agree on.

// The boundary: what is refused, and how the page is told.
mod error;
mod input;

// Samples in physics time.
#[cfg(any(feature = "chapter", feature = "robots"))]
mod samples;

// How numbers are written that the builds are compared on.
#[cfg(any(feature = "chapter", feature = "robots"))]
mod parity;

// The modules of the page.
#[cfg(feature = "chapter")]
mod chapter;
#[cfg(feature = "flips")]
mod flips;
#[cfg(feature = "robots")]
mod robots;

#[cfg(feature = "chapter")]
pub use chapter::{
    ArmEnergies, Blade, BladeBooks, Brick, BrickDrift, ClosedForm, FallingArm, HoldForecast, HoldTorques,
    Race, Replay, ThrownArm, ThrownBooks, Workbench, integrator_names, knife_edge_defect, parity_values,
};
pub use error::LabError;
#[cfg(feature = "flips")]
pub use flips::FlipMap;
#[cfg(feature = "robots")]
pub use robots::{
    DrawnBody, DrawnJoint, DrawnShape, FeltMass, Robot, RobotBooks, RobotControl, RobotCoordinate,
    RobotCounts, RobotFiles, RobotPose, RobotTorques, one_line_text, robot_parity_values,
};
