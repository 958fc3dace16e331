//! The options of reading a robot file.

use std::path::PathBuf;

/// The options of reading a robot file. By default the base is fixed to the world, and the reading is not
/// strict.
#[doc(alias = "Options")]
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct LoadOptions {
    /// Whether the base floats, which adds six degrees of freedom.
    pub floating_base: bool,
    /// Whether warnings are errors. Warnings are suspicious values, and physics that is not in the model (a
    /// gear reduction, a spring, an unknown attribute of an inertia).
    pub strict: bool,
    /// Whether inertias that no rigid body has are repaired. The wrong moment is moved to the nearest valid
    /// value (`MassProperties::repaired`), and an inertia without mass is removed. The report gives the old
    /// and the new values. Without this option they are taken as written, with a warning. A strict reading
    /// refuses them in any case.
    pub repair_inertia: bool,
    /// Folders that are searched for `package://NAME/…` before those of `ROS_PACKAGE_PATH` and
    /// `AMENT_PREFIX_PATH`: packages, or folders that contain packages.
    pub package_path: Vec<PathBuf>,
    /// Whether the other files that a file names must be in its folder, as for archives and untrusted files.
    /// By default they may be anywhere on the disk, as in MuJoCo. Files in memory are always confined.
    pub confined: bool,
    /// The SRDF file of the robot: groups, named poses, passive joints, the joint to the world, and pairs of
    /// links that never touch. The functions of `robot_dynamics` read it for every format of robot file.
    /// Without it no SRDF file is read, not even one beside the robot's file.
    pub srdf: Option<Srdf>,
}

/// An SRDF file, or its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Srdf {
    /// The path of the file. For a robot from files in memory it is one of them.
    File(PathBuf),
    /// The content of a file.
    Text(String),
}

impl LoadOptions {
    /// The same options with a floating base.
    pub fn with_floating_base(self) -> Self {
        Self { floating_base: true, ..self }
    }

    /// The same options with repair of inertias that no rigid body has.
    pub fn with_repaired_inertia(self) -> Self {
        Self { repair_inertia: true, ..self }
    }

    /// The same options with one more folder that is searched for packages.
    ///
    /// ```
    /// let options = robot_dynamics_xml::LoadOptions::default().with_package_path("/opt/robots/share");
    /// assert_eq!(options.package_path.len(), 1);
    /// ```
    pub fn with_package_path(mut self, folder: impl Into<PathBuf>) -> Self {
        self.package_path.push(folder.into());
        self
    }

    /// The same options with all other files confined to the folder of the main file.
    ///
    /// ```
    /// assert!(robot_dynamics_xml::LoadOptions::default().with_confined().confined);
    /// ```
    pub fn with_confined(self) -> Self {
        Self { confined: true, ..self }
    }

    /// The same options with this SRDF file of the robot.
    ///
    /// ```
    /// let options = robot_dynamics_xml::LoadOptions::default().with_srdf("arm.srdf");
    /// assert_eq!(options.srdf, Some(robot_dynamics_xml::Srdf::File("arm.srdf".into())));
    /// ```
    pub fn with_srdf(self, path: impl Into<PathBuf>) -> Self {
        Self { srdf: Some(Srdf::File(path.into())), ..self }
    }

    /// The same options with the text of the robot's SRDF file: see [`with_srdf`](Self::with_srdf).
    ///
    /// ```
    /// let options = robot_dynamics_xml::LoadOptions::default().with_srdf_text("<robot name='arm'/>");
    /// assert!(matches!(options.srdf, Some(robot_dynamics_xml::Srdf::Text(_))));
    /// ```
    pub fn with_srdf_text(self, text: impl Into<String>) -> Self {
        Self { srdf: Some(Srdf::Text(text.into())), ..self }
    }

    /// The same options with warnings as errors.
    pub fn with_strict(self) -> Self {
        Self { strict: true, ..self }
    }
}
