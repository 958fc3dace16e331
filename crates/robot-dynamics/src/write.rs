//! From a robot to a file, of whichever format.

use std::path::Path;

use multibody::{RobotDescription, WriteError, WrittenFile};

/// A format of robot files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// The robot description format of ROS.
    Urdf,
    /// MuJoCo's.
    Mjcf,
}

impl Format {
    /// The format that a file's name tells: `.urdf`, or `.xml` and `.mjcf` for MJCF.
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

/// Writes a robot in a format: see [`urdf::write()`] and [`mjcf::write()`]. `folder` is where the file will lie.
///
/// ```
/// use robot_dynamics::{Format, Options, describe, describe_text, write};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
/// let panda = describe(file, &Options::default())?;
/// let written = write(&panda.description, Format::Mjcf, None)?;
/// assert_eq!(written.lost_physics().count(), 0);
/// let back = describe_text(&written.text, &Options::default())?.compile()?.model;
/// let q = [0.3; 7];
/// let off = back.mass_matrix(&q)? - panda.compile()?.model.mass_matrix(&q)?;
/// assert!(off.amax() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WriteError`] for what the format has no words for without another robot coming of it.
pub fn write(
    robot: &RobotDescription,
    format: Format,
    folder: Option<&Path>,
) -> Result<WrittenFile, WriteError> {
    match format {
        Format::Urdf => urdf::write(robot, folder),
        Format::Mjcf => mjcf::write(robot, folder),
    }
}
