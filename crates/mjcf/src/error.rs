//! The reasons for which an MJCF file is refused.

use robot_dynamics_description::{LoadReport, RefusedFile, Severity};
use robot_dynamics_xml::XmlError;
use thiserror::Error;

/// A refused MJCF file: all of its errors, in the order of its lines.
///
/// ```
/// let text = r#"<mujoco><worldbody>
///     <body name="a"><joint type="hing"/></body>
///     <body name="a" pos="0 zero 0"/></worldbody></mujoco>"#;
/// let refused = robot_dynamics_mjcf::parse(text, &robot_dynamics_mjcf::LoadOptions::default()).unwrap_err();
/// let lines: Vec<_> = refused.errors().iter().map(|error| error.line()).collect();
/// assert_eq!(lines, [Some(2), Some(3), Some(3)]);
/// ```
pub type LoadError = RefusedFile<MjcfError>;

impl From<MjcfError> for LoadError {
    fn from(error: MjcfError) -> Self {
        Self::new(vec![error], MjcfError::line, LoadReport::default())
    }
}

/// One error of an MJCF file, with its place and advice.
///
/// `line` counts from 1; `place` is the element, as in `joint "thumb"`, after the name of the file if it is
/// an included one.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The message of each variant names its fields.
pub enum MjcfError {
    /// The file cannot be read, or is not XML; `file` is empty for the main file.
    #[error("{}{source}", if file.is_empty() { String::new() } else { format!("{file}: ") })]
    Xml { file: String, source: XmlError },
    /// Well-formed XML of another kind.
    #[error("line {line}: the outermost element is <{found}>, not <mujoco>; {advice}")]
    NotMjcf { line: usize, found: String, advice: &'static str },
    /// A file that cannot be included.
    #[error("line {line}: {place}: {file:?} cannot be included: {reason}")]
    Include { line: usize, place: String, file: String, reason: String },
    /// A model that cannot be attached.
    #[error("line {line}: {place}: {file:?} cannot be attached: {reason}")]
    Attach { line: usize, place: String, file: String, reason: String },

    /// A required attribute is missing.
    #[error("line {line}: {place}: the attribute `{attribute}` is missing; write {attribute}=\"{example}\"")]
    MissingAttribute { line: usize, place: String, attribute: &'static str, example: &'static str },
    /// Text where a number belongs.
    #[error("line {line}: {place}: {attribute}={text:?} is not a number{advice}")]
    NotANumber { line: usize, place: String, attribute: String, text: String, advice: &'static str },
    /// NaN, infinity, or a number that overflows a double.
    #[error("line {line}: {place}: {attribute}={text:?} is not a finite number; correct it")]
    NotFinite { line: usize, place: String, attribute: String, text: String },
    /// A number larger than any length, mass or inertia.
    #[error("line {line}: {place}: {attribute}={text:?} is larger than 1e30; use SI units (m, kg, s)")]
    TooBig { line: usize, place: String, attribute: String, text: String },
    /// Too few or too many numbers in a list.
    #[error("line {line}: {place}: {attribute}={text:?} has {found} numbers instead of {expected}")]
    WrongCount { line: usize, place: String, attribute: String, text: String, expected: String, found: usize },
    /// An unknown keyword.
    #[error("line {line}: {place}: {attribute}={text:?} is unknown; use {known}")]
    UnknownWord { line: usize, place: String, attribute: String, text: String, known: String },
    /// A negative value of a quantity that cannot be negative.
    #[error("line {line}: {place}: {attribute}={value} is negative; it must be zero or positive")]
    Negative { line: usize, place: String, attribute: String, value: f64 },
    /// A direction, a quaternion or a length that is zero.
    #[error("line {line}: {place}: {attribute} is zero; {advice}")]
    Zero { line: usize, place: String, attribute: String, advice: &'static str },
    /// Two attributes for one quantity.
    #[error("line {line}: {place}: both `{first}` and `{second}` are given; keep one of them")]
    Both { line: usize, place: String, first: String, second: String },

    /// A reference to an element that does not exist.
    #[error("line {line}: {place}: the {what} {name:?} does not exist; add it or correct the name")]
    UnknownName { line: usize, place: String, what: &'static str, name: String },
    /// A name that is used twice.
    #[error(
        "line {line}: {place}: the {what} {name:?} is already defined on line {first}; give each its own name"
    )]
    DuplicateName { line: usize, place: String, what: &'static str, name: String, first: usize },
    /// A misplaced element, or a combination that has no meaning.
    #[error("line {line}: {place}: {reason}")]
    Misplaced { line: usize, place: String, reason: String },
    /// Too many elements, for example from nested replicates.
    #[error("line {line}: {place}: more than {limit} {what}; this is not a robot file")]
    TooMany { line: usize, place: String, what: &'static str, limit: usize },
    /// The inertia of a body comes from a mesh that cannot be read.
    #[error(
        "line {line}: {place}: the inertia of this body comes from mesh {mesh:?}, which cannot be used: {reason}"
    )]
    Mesh { line: usize, place: String, mesh: String, reason: String },

    /// A warning in a strict reading.
    #[error("line {line}: {place}: {message} (a warning, which a strict reading refuses)")]
    Strict { line: usize, place: String, message: String },
}

impl MjcfError {
    /// The line by which errors are sorted. A limit on the whole file comes first, so that it is always among
    /// the listed errors.
    pub(crate) fn sorted_at(&self) -> Option<usize> {
        if matches!(self, Self::TooMany { .. }) { None } else { self.line() }
    }

    /// The line of the error, from 1; `None` for errors of a whole file.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Xml { source, .. } => source.line(),
            Self::NotMjcf { line, .. }
            | Self::Include { line, .. }
            | Self::Attach { line, .. }
            | Self::MissingAttribute { line, .. }
            | Self::NotANumber { line, .. }
            | Self::NotFinite { line, .. }
            | Self::TooBig { line, .. }
            | Self::WrongCount { line, .. }
            | Self::UnknownWord { line, .. }
            | Self::Negative { line, .. }
            | Self::Zero { line, .. }
            | Self::Both { line, .. }
            | Self::UnknownName { line, .. }
            | Self::DuplicateName { line, .. }
            | Self::Misplaced { line, .. }
            | Self::TooMany { line, .. }
            | Self::Mesh { line, .. }
            | Self::Strict { line, .. } => Some(*line),
        }
    }

    /// The element of the error, as in `joint "elbow"`; `None` for errors of a whole file.
    pub fn place(&self) -> Option<&str> {
        match self {
            Self::Xml { .. } | Self::NotMjcf { .. } => None,
            Self::Include { place, .. }
            | Self::Attach { place, .. }
            | Self::MissingAttribute { place, .. }
            | Self::NotANumber { place, .. }
            | Self::NotFinite { place, .. }
            | Self::TooBig { place, .. }
            | Self::WrongCount { place, .. }
            | Self::UnknownWord { place, .. }
            | Self::Negative { place, .. }
            | Self::Zero { place, .. }
            | Self::Both { place, .. }
            | Self::UnknownName { place, .. }
            | Self::DuplicateName { place, .. }
            | Self::Misplaced { place, .. }
            | Self::TooMany { place, .. }
            | Self::Mesh { place, .. }
            | Self::Strict { place, .. } => Some(place),
        }
    }

    /// Always [`Severity::Error`].
    pub fn severity(&self) -> Severity {
        Severity::Error
    }
}
