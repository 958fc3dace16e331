//! The library's interface for the lab's page.
//!
//! Every call that can fail returns a [`LabError`], which JavaScript receives as an `Error` with the same
//! message. A panic would stop the module, so calls check for numbers that are not finite and wrong lengths.
//! Vectors are plain lists of numbers, and matrices are in row-major order. The library does all
//! computations. The types here hold a state, count steps, and keep samples for the plots.
//!
//! The feature `chapter` contains the experiments of the chapter, `flips` the map of first flips, `robots`
//! robots from files. Each is a module of its own: the page opens with the first and loads the others on
//! demand. The last two are built twice, with vector registers (simd128) and without.
//!
//! The tests run the same code natively. [`parity_values`] and [`robot_parity_values`] list the numbers that
//! all builds must agree on.

// Checks of arguments, and errors.
mod error;
mod input;

// Samples over simulated time.
#[cfg(any(feature = "chapter", feature = "robots"))]
mod samples;

// The format of the numbers that builds are compared by.
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
    ArmEnergies, Blade, BladeEnergyAccount, Brick, BrickDrift, ClosedForm, FallingArm, HoldForecast,
    HoldTorques, Race, Replay, ThrownArm, ThrownArmEnergyAccount, Workbench, integrator_names,
    knife_edge_defect, parity_values,
};
pub use error::LabError;
#[cfg(feature = "flips")]
pub use flips::FlipMap;
#[cfg(feature = "robots")]
pub use robots::{
    DrawnBody, DrawnJoint, DrawnShape, FeltMass, Robot, RobotControl, RobotCoordinate, RobotCounts,
    RobotEnergyAccount, RobotFiles, RobotPose, RobotTorques, one_line_text, robot_parity_values,
};
