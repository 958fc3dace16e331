//! How a robot file is to be read.

use std::path::PathBuf;

/// Choices that a robot file leaves to its reader. The default: base fixed to the world, not strict.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The root link moves freely in the world: six more degrees of freedom.
    pub floating_base: bool,
    /// Every warning is an error: what is suspicious, and physics that would be ignored (a gear reduction, a
    /// spring, an unknown attribute of an inertia).
    pub strict: bool,
    /// Where no rigid body has the moments that the file states, the moment at fault is moved to where the law
    /// just holds (`MassProperties::repaired`), and an inertia without mass is dropped, with the old
    /// and the new values in the report. Without this they are taken as written, with a warning. A strict reading
    /// refuses them all the same.
    pub repair_inertia: bool,
    /// Folders in which `package://NAME/…` is looked for before those of `ROS_PACKAGE_PATH`: packages, or folders that hold
    /// them.
    pub package_path: Vec<PathBuf>,
}

impl Options {
    /// The same options with the root link free to move in the world.
    pub fn with_floating_base(self) -> Self {
        Self { floating_base: true, ..self }
    }

    /// The same options, repairing inertias that no rigid body has.
    pub fn with_repaired_inertia(self) -> Self {
        Self { repair_inertia: true, ..self }
    }

    /// The same options, with one more folder in which packages are looked for.
    ///
    /// ```
    /// let options = robot_xml::Options::default().with_package_path("/opt/robots/share");
    /// assert_eq!(options.package_path.len(), 1);
    /// ```
    pub fn with_package_path(mut self, folder: impl Into<PathBuf>) -> Self {
        self.package_path.push(folder.into());
        self
    }

    /// The same options, refusing files with a warning.
    pub fn with_strict(self) -> Self {
        Self { strict: true, ..self }
    }
}
