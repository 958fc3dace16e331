//! The text of a robot's file, with a list of what the format cannot represent.

/// The text of a robot's file, and the parts of the robot that it lacks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WrittenFile {
    /// The file's text.
    pub text: String,
    /// The parts that the format cannot represent, or represents differently.
    pub left_out: Vec<UnsupportedFeature>,
}

impl WrittenFile {
    /// For writers of robot files.
    ///
    /// ```
    /// use robot_dynamics::description::{UnsupportedFeature, WrittenFile};
    /// let spring = UnsupportedFeature::new("tendon \"t\"", "the format has no tendons", true);
    /// let file = WrittenFile::new("<robot/>", vec![spring]);
    /// assert_eq!(file.lost_physics().count(), 1);
    /// ```
    pub fn new(text: impl Into<String>, left_out: Vec<UnsupportedFeature>) -> Self {
        Self { text: text.into(), left_out }
    }

    /// The omissions that affect, or may affect, the robot's motion.
    pub fn lost_physics(&self) -> impl Iterator<Item = &UnsupportedFeature> {
        self.left_out.iter().filter(|left_out| left_out.physics)
    }
}

/// A part of a robot that a file's format cannot represent, or represents differently.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[doc(alias = "LeftOut")]
pub struct UnsupportedFeature {
    /// Its owner, as in `joint "elbow"`.
    pub place: String,
    /// A description of the loss, in plain words.
    pub message: String,
    /// Whether the omission affects the robot's motion.
    pub physics: bool,
}

impl UnsupportedFeature {
    /// An omission at a place such as `joint "elbow"`.
    pub fn new(place: impl Into<String>, message: impl Into<String>, physics: bool) -> Self {
        Self { place: place.into(), message: message.into(), physics }
    }
}
