//! Robots from files.

// Descriptions of a robot for the page.
mod account;
mod coordinate;
mod drawn;
mod files;
mod torques;

// The robot and its operations.
mod beginning;
mod choice;
mod contacts;
mod controls;
mod hand;
mod loops;
mod meshes;
mod motion;
mod robot;

mod parity;

pub use account::{RobotBooks, RobotCounts};
pub use controls::{RobotControl, RobotPose};
pub use coordinate::RobotCoordinate;
pub use drawn::{DrawnBody, DrawnJoint, DrawnShape};
pub use files::RobotFiles;
pub use hand::FeltMass;
pub use parity::robot_parity_values;
pub use robot::{Robot, one_line_text};
pub use torques::RobotTorques;
