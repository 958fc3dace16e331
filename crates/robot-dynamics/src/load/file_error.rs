//! The error of a refused robot file, of any format.

use robot_dynamics_number::{Classified, ErrorKind};
use thiserror::Error;

use crate::description::{LoadReport, ModelError, RefusedFile};
use crate::scene_file::SceneFault;

/// The reason for which a robot file is refused, by its format, or its description is invalid.
///
/// ```
/// use robot_dynamics::{FileError, LoadOptions, load_description_from_text};
/// let refused = load_description_from_text("<mujoco><worldbody><joint/></worldbody></mujoco>", &LoadOptions::default());
/// let refused = refused.expect_err("a joint of the world");
/// assert!(matches!(refused, FileError::Mjcf(_)) && refused.messages().len() == 1);
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
#[doc(alias = "LoadError")]
pub enum FileError {
    /// A file with the outermost element `<robot>`, or one of an unknown format.
    #[error(transparent)]
    Urdf(#[from] robot_dynamics_urdf::LoadError),
    /// A file with the outermost element `<mujoco>`.
    #[error(transparent)]
    Mjcf(#[from] robot_dynamics_mjcf::LoadError),
    /// A USD file.
    #[cfg(feature = "usd")]
    #[error(transparent)]
    Usd(#[from] robot_dynamics_usd::LoadError),
    /// The SRDF file of the robot: see [`LoadOptions::with_srdf`](crate::LoadOptions::with_srdf).
    #[error("{file}: {source}")]
    Srdf {
        /// Its path; empty for a text.
        file: String,
        /// Its errors.
        source: robot_dynamics_urdf::LoadError,
    },
    /// A file with the outermost element `<scene>`.
    #[error(transparent)]
    Scene(#[from] RefusedFile<SceneFault>),
    /// A file that was read, with an invalid description.
    #[error("{source}")]
    Model {
        /// The problem of the description.
        source: Box<ModelError>,
        /// The warnings and notes on the file.
        report: Box<LoadReport>,
    },
}

impl Classified for FileError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Urdf(error) => error.kind(),
            Self::Mjcf(error) => error.kind(),
            #[cfg(feature = "usd")]
            Self::Usd(error) => error.kind(),
            Self::Srdf { source, .. } => source.kind(),
            Self::Scene(error) => error.kind(),
            Self::Model { source, .. } => source.kind(),
        }
    }
}

impl FileError {
    /// The messages of the listed errors, each with line and place; see [`unlisted`](Self::unlisted).
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Urdf(error) => error.errors().iter().map(ToString::to_string).collect(),
            Self::Mjcf(error) => error.errors().iter().map(ToString::to_string).collect(),
            #[cfg(feature = "usd")]
            Self::Usd(error) => error.errors().iter().map(ToString::to_string).collect(),
            Self::Srdf { file, source } => {
                source.errors().iter().map(|error| format!("{file}: {error}")).collect()
            }
            Self::Scene(error) => error.errors().iter().map(ToString::to_string).collect(),
            Self::Model { source, .. } => vec![source.to_string()],
        }
    }

    /// The number of errors that are not listed.
    pub fn unlisted(&self) -> usize {
        match self {
            Self::Urdf(error) => error.unlisted(),
            Self::Mjcf(error) => error.unlisted(),
            #[cfg(feature = "usd")]
            Self::Usd(error) => error.unlisted(),
            Self::Srdf { source, .. } => source.unlisted(),
            Self::Scene(error) => error.unlisted(),
            Self::Model { .. } => 0,
        }
    }

    /// Whether the file could not be read. The message then names the file.
    pub fn is_unreadable(&self) -> bool {
        match self {
            Self::Urdf(error) => {
                matches!(error.errors(), [robot_dynamics_urdf::UrdfError::Unreadable { .. }])
            }
            Self::Mjcf(error) => matches!(
                error.errors(),
                [robot_dynamics_mjcf::MjcfError::Xml { file, source: robot_dynamics_xml::XmlError::Unreadable { .. } }] if file.is_empty()
            ),
            #[cfg(feature = "usd")]
            Self::Usd(_) => false,
            Self::Srdf { .. } | Self::Scene(_) | Self::Model { .. } => false,
        }
    }

    /// The warnings and notes on the file, as far as it could be read.
    pub fn report(&self) -> &LoadReport {
        match self {
            Self::Urdf(error) => error.report(),
            Self::Mjcf(error) => error.report(),
            #[cfg(feature = "usd")]
            Self::Usd(error) => error.report(),
            Self::Srdf { source, .. } => source.report(),
            Self::Scene(error) => error.report(),
            Self::Model { report, .. } => report,
        }
    }
}
