//! Writes robot files of all formats.

use std::path::Path;

use crate::description::{ModelError, RobotDescription, WrittenFile};

/// A format of robot files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// URDF, the format of ROS.
    Urdf,
    /// MJCF, the format of MuJoCo.
    Mjcf,
}

impl Format {
    /// The format of a file by its extension: `.urdf` for URDF, `.xml` and `.mjcf` for MJCF.
    ///
    /// ```
    /// use robot_dynamics::Format;
    /// assert_eq!(Format::of("arm.urdf"), Some(Format::Urdf));
    /// assert_eq!(Format::of("arm.XML"), Some(Format::Mjcf));
    /// assert_eq!(Format::of("arm"), None);
    /// ```
    pub fn of(path: impl AsRef<Path>) -> Option<Self> {
        let ending = path.as_ref().extension()?.to_string_lossy().to_lowercase();
        match ending.as_str() {
            "urdf" => Some(Self::Urdf),
            "xml" | "mjcf" => Some(Self::Mjcf),
            _ => None,
        }
    }
}

/// Writes a robot as the text of a file: see [`urdf::write()`](crate::urdf::write()) and
/// [`mjcf::write()`](crate::mjcf::write()). `folder` is the folder of the new file.
///
/// ```
/// use robot_dynamics::{Format, LoadOptions, load_description, load_description_from_text, write};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
/// let panda = load_description(file, &LoadOptions::default())?;
/// let written = write(&panda.description, Format::Mjcf, None)?;
/// assert_eq!(written.lost_physics().count(), 0);
/// let back = load_description_from_text(&written.text, &LoadOptions::default())?.compile()?.model;
/// let q = [0.3; 7];
/// let off = back.mass_matrix(&q)? - panda.compile()?.model.mass_matrix(&q)?;
/// assert!(off.amax() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ModelError`] for features that the format lacks and that change the robot, as a helical joint.
pub fn write(
    robot: &RobotDescription,
    format: Format,
    folder: Option<&Path>,
) -> Result<WrittenFile, ModelError> {
    match format {
        Format::Urdf => robot_dynamics_urdf::write(robot, folder),
        Format::Mjcf => robot_dynamics_mjcf::write(robot, folder),
    }
}
