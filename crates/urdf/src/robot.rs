//! The result of reading a file.

use std::path::Path;

use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{Base, LoadReport, RobotDescription};

use crate::reader::Reader;
use crate::{LoadError, UrdfError};

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

impl Robot {
    /// Completes the report of a robot that was read from these files, beside those of its shapes.
    pub(crate) fn finish<'f>(
        mut reader: Reader<'_>,
        robot: RobotDescription,
        angles: Vec<WrittenAngles>,
        files: impl IntoIterator<Item = &'f Path>,
    ) -> Result<Self, LoadError> {
        let mut report = core::mem::take(&mut reader.report);
        let meshes = robot.shapes.iter().filter_map(|shape| shape.shape.file()?.1);
        report.add_files(files);
        report.add_files(meshes);
        robot.name.clone_into(&mut report.robot);
        report.counts.links = robot.links.len();
        report.counts.joints = robot.joints.len();
        let free = robot.joints.iter().filter(|joint| joint.mimic.is_none());
        report.counts.degrees_of_freedom = free.map(|joint| joint.kind.nv()).sum::<usize>()
            + if robot.base == Base::Floating { 6 } else { 0 };
        report.sort();
        reader.errors.append(&mut reader.refused_warnings);
        if reader.errors.is_empty() {
            Ok(Self { description: robot, report, angles })
        } else {
            Err(LoadError::new(reader.errors, UrdfError::sorted_at, report))
        }
    }
}
