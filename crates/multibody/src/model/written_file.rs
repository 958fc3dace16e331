//! A robot as the text of a file, with what the file's format could not say.

use thiserror::Error;

use crate::ModelError;

/// The text of a robot's file, and the account of what is not in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WrittenFile {
    /// The file's text.
    pub text: String,
    /// What the format has no words for, or says in another way.
    pub left_out: Vec<LeftOut>,
}

impl WrittenFile {
    /// For writers of robot files.
    ///
    /// ```
    /// use multibody::{LeftOut, WrittenFile};
    /// let spring = LeftOut::new("tendon \"t\"", "the format has no tendons", true);
    /// let file = WrittenFile::new("<robot/>", vec![spring]);
    /// assert_eq!(file.lost_physics().count(), 1);
    /// ```
    pub fn new(text: impl Into<String>, left_out: Vec<LeftOut>) -> Self {
        Self { text: text.into(), left_out }
    }

    /// What changes, or may change, how the robot moves.
    pub fn lost_physics(&self) -> impl Iterator<Item = &LeftOut> {
        self.left_out.iter().filter(|left_out| left_out.physics)
    }
}

/// Something of a robot that a file's format has no words for, or says in another way.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeftOut {
    /// What it belongs to, as in `joint "elbow"`.
    pub place: String,
    /// What is lost or said otherwise, in plain words.
    pub message: String,
    /// Whether the robot moves differently without it.
    pub physics: bool,
}

impl LeftOut {
    /// At a place such as `joint "elbow"`.
    pub fn new(place: impl Into<String>, message: impl Into<String>, physics: bool) -> Self {
        Self { place: place.into(), message: message.into(), physics }
    }
}

/// Why a robot cannot be written in a file's format.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// It is no robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The format has no words for its tree; every reason.
    #[error("{}", .0.join("; "))]
    Unwritable(Vec<String>),
}
