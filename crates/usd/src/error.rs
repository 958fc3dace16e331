//! The reasons for which a USD file is refused.

use std::path::PathBuf;

use robot_dynamics_description::{LoadReport, RefusedFile, Severity};
use thiserror::Error;

/// A refused USD file: all of its errors.
pub type LoadError = RefusedFile<UsdError>;

impl From<UsdError> for LoadError {
    fn from(error: UsdError) -> Self {
        Self::new(vec![error], UsdError::line, LoadReport::default())
    }
}

/// One error of a USD file, with the path of its prim and advice.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The message of each variant names its fields.
pub enum UsdError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    /// The file is larger than the limit.
    #[error("the file has more than {limit} bytes, the largest size of a robot file")]
    TooLarge { limit: usize },
    /// The files and their copies exceed a limit.
    #[error("more than {limit} {what}; this is not a robot file")]
    TooMany { what: &'static str, limit: usize },
    /// The file is not USD, or it is damaged.
    #[error("the file is not valid USD: {reason}")]
    BadFile { reason: String },
    /// A prim without a meaning for the robot.
    #[error("{place}: {reason}")]
    BadPrim { place: String, reason: String },
    /// A warning in a strict reading.
    #[error("{place}: {message} (a warning, which a strict reading refuses)")]
    Strict { place: String, message: String },
}

impl UsdError {
    /// Always `None`: prims have paths, and no lines.
    pub fn line(&self) -> Option<usize> {
        None
    }

    /// The path of the prim; `None` for errors of the whole file.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::BadPrim { place, .. } | Self::Strict { place, .. } => Some(place.clone()),
            _ => None,
        }
    }

    /// Always [`Severity::Error`].
    pub fn severity(&self) -> Severity {
        Severity::Error
    }
}
