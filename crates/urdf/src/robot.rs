//! The result of reading a file.

use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{LoadReport, RobotDescription};

/// A robot and the report of how it was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Robot {
    /// Links and joints, as written in the file.
    pub description: RobotDescription,
    /// Everything that was read, defaulted, suspicious or ignored.
    pub report: LoadReport,
    /// The angles of all frames as written, before conversion to rotations.
    pub angles: Vec<WrittenAngles>,
}
