//! Robots from files.

// Data for the page, and the robot's own.
mod account;
mod choice;
mod control_line;
mod coordinate;
mod drawing;
mod files;
mod hand;
mod step;
mod text;
mod torques;

// The robot and its operations.
mod contacts;
mod controls;
mod grip;
mod loops;
mod meshes;
mod motion;
mod quantities;
mod robot;
mod setup;
mod start;

mod parity;

pub use account::{RobotCounts, RobotEnergyAccount};
pub use controls::{RobotControl, RobotPose};
pub use coordinate::RobotCoordinate;
pub use drawing::{DrawnBody, DrawnJoint, DrawnShape};
pub use files::RobotFiles;
pub use grip::FeltMass;
pub use parity::robot_parity_values;
pub use robot::Robot;
pub use text::one_line_text;
pub use torques::RobotTorques;
