//! Why a robot file was refused.

use std::path::PathBuf;

use multibody::{LoadReport, RefusedFile, Severity};
use robot_xml::{XmlError, excerpt};
use thiserror::Error;

/// Why a robot file was refused: every error in it, in the order of its lines.
///
/// ```
/// let text = r#"<robot name="r"><link name="a"/><link name="a"/>
///     <joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint></robot>"#;
/// let refused = urdf::parse(text, &urdf::Options::default()).unwrap_err();
/// let places: Vec<_> = refused.errors().iter().map(|e| (e.line(), e.place())).collect();
/// let place = |words: &str| Some(words.to_owned());
/// let joint = place(r#"joint "j""#);
/// assert_eq!(places, [(Some(1), place(r#"link "a""#)), (Some(2), joint.clone()), (Some(2), joint)]);
/// ```
pub type LoadError = RefusedFile<UrdfError>;

impl From<UrdfError> for LoadError {
    fn from(error: UrdfError) -> Self {
        Self::new(vec![error], UrdfError::line, LoadReport::default())
    }
}

/// One error of a robot file: what is wrong, where, and what to do.
///
/// `line` counts from 1; `place` is the element, as in `joint "elbow"/limit`.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The fields are the nouns of each variant's sentence.
pub enum UrdfError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    /// The file is not text.
    #[error(
        "byte {byte} is not UTF-8 text; save the file as UTF-8, and check that it is a robot file at all"
    )]
    NotUtf8 { byte: usize },
    /// More text than any robot file has.
    #[error("the file holds more than {limit} bytes; a robot file is text of at most that size")]
    TooLarge { limit: usize },
    /// Nothing to read.
    #[error("the file is empty; a URDF file holds one <robot> element")]
    Empty,
    /// The text is not well-formed XML.
    #[error("line {line}, column {column}: not well-formed XML: {reason}")]
    BadXml { line: usize, column: usize, reason: String },
    /// A document type declaration, by which a few bytes can expand to gigabytes.
    #[error("line {line}: a URDF file needs no <!DOCTYPE …>, and its entities are not expanded; delete it")]
    DocumentType { line: usize },
    /// Elements nested beyond any robot file.
    #[error("line {line}: elements are nested deeper than {limit}; a URDF file needs fewer than ten levels")]
    TooDeep { line: usize, limit: usize },
    /// More attributes or namespaces on an element than any robot file has.
    #[error("line {line}: more than {limit} {what}; this is not a robot file")]
    TooMany { line: usize, what: &'static str, limit: usize },
    /// Well-formed XML of another kind.
    #[error("line {line}: the outermost element is <{found}>, not <robot>; {advice}")]
    NotARobot { line: usize, found: String, advice: &'static str },

    /// A xacro file, of which URDF is yet to be made.
    #[error(
        "line {line}: this is a xacro file, and `xacro:{instruction}` ({count} such) is not expanded: run `xacro {file} > \
         robot.urdf`, with the arguments that the robot takes, and load robot.urdf; xacro is part of ROS, and without ROS \
         `pip install xacrodoc` brings `xacrodoc {file} -o robot.urdf`"
    )]
    Unexpanded { line: usize, instruction: String, count: usize, file: String },

    /// A required attribute is not there.
    #[error("line {line}: {place}: the attribute `{attribute}` is missing; write {example}")]
    MissingAttribute { line: usize, place: String, attribute: String, example: String },
    /// A required element is not there.
    #[error("line {line}: {place}: the element <{element}> is missing; {advice}")]
    MissingElement { line: usize, place: String, element: &'static str, advice: &'static str },
    /// A name of no letters.
    #[error("line {line}: {place}: the attribute `{attribute}` is empty; give a name")]
    EmptyName { line: usize, place: String, attribute: String },
    /// Text where a number belongs.
    #[error("line {line}: {place}: {attribute}={text:?} is not a number{advice}")]
    NotANumber { line: usize, place: String, attribute: String, text: String, advice: &'static str },
    /// NaN, infinity, or a number that no double holds.
    #[error("line {line}: {place}: {attribute}={text:?} is not a finite number; {advice}")]
    NotFinite { line: usize, place: String, attribute: String, text: String, advice: &'static str },
    /// Larger than any length, mass or inertia.
    #[error("line {line}: {place}: {attribute}={text:?} is beyond 1e30; give SI units (m, kg, s, rad)")]
    TooBig { line: usize, place: String, attribute: String, text: String },
    /// Too few or too many numbers in a list.
    #[error("line {line}: {place}: {attribute}={text:?} holds {found} numbers, not {expected}")]
    WrongCount { line: usize, place: String, attribute: String, text: String, expected: usize, found: usize },
    /// A quantity that cannot be negative is.
    #[error("line {line}: {place}: {attribute}={value} is negative; {advice}")]
    Negative { line: usize, place: String, attribute: String, value: f64, advice: &'static str },
    /// Two ways to say one thing, which may disagree.
    #[error("line {line}: {place}: both `{first}` and `{second}` are given; keep one of them")]
    Both { line: usize, place: String, first: &'static str, second: &'static str },
    /// A quaternion of length zero.
    #[error("line {line}: {place}: quat_xyzw is zero and no rotation; write \"0 0 0 1\" for none")]
    ZeroQuaternion { line: usize, place: String },

    /// A joint type that URDF does not know.
    #[error(
        "line {line}: joint {joint:?}: the type {found:?} is unknown; use revolute, continuous, prismatic, fixed, \
         floating, planar or spherical"
    )]
    UnknownJointType { line: usize, joint: String, found: String },
    /// An axis without direction.
    #[error("line {line}: joint {joint:?}: the axis is zero; give a direction such as xyz=\"0 0 1\"")]
    ZeroAxis { line: usize, joint: String },

    /// A robot without links.
    #[error("line {line}: robot {robot:?} has no links; a robot has at least one <link name=\"…\"/>")]
    NoLinks { line: usize, robot: String },
    /// One name for two things.
    #[error("line {line}: {what} {name:?} is already defined on line {first}; give each its own name")]
    DuplicateName { line: usize, what: &'static str, name: String, first: usize },
    /// A joint to or from a link that is not there.
    #[error(
        "line {line}: joint {joint:?}: its {role} link {link:?} does not exist; add it or correct the name"
    )]
    UnknownLink { line: usize, joint: String, role: &'static str, link: String },
    /// A joint from a link to itself.
    #[error("line {line}: joint {joint:?} joins link {link:?} to itself; parent and child must differ")]
    SelfParent { line: usize, joint: String, link: String },
    /// A link moved by two joints.
    #[error(
        "line {line}: link {link:?} is the child of joint {joint:?}, but already of joint {first_joint:?} (line \
         {first}); a tree has one, and loops are not URDF"
    )]
    TwoParents { line: usize, link: String, joint: String, first_joint: String, first: usize },
    /// Links in a ring.
    #[error(
        "line {line}: the joints {} form a cycle; remove one of them, so that a root link remains",
        joints.join(" → ")
    )]
    Cycle { line: usize, joints: Vec<String> },

    /// A mimic joint or its leader is not of one degree of freedom.
    #[error(
        "line {line}: joint {joint:?} mimics {leader:?}, but {which} is {kind}; both must be revolute, continuous \
         or prismatic"
    )]
    MimicKind { line: usize, joint: String, leader: String, which: String, kind: &'static str },
    /// The leader is not there.
    #[error(
        "line {line}: joint {joint:?} mimics {leader:?}, which does not exist; add it or correct the name"
    )]
    UnknownMimic { line: usize, joint: String, leader: String },
    /// Joints that follow each other in a ring.
    #[error(
        "line {line}: the joints {} mimic each other in a ring; let one of them be free",
        joints.join(" → ")
    )]
    MimicCycle { line: usize, joints: Vec<String> },

    /// Strict reading met a warning.
    #[error(
        "line {line}: {place}: {message} (a warning, which strict reading refuses; correct it or do not be strict)"
    )]
    Strict { line: usize, place: String, message: String },
}

impl UrdfError {
    /// The line at fault, from 1; `None` where it is not about a line.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Unreadable { .. } | Self::NotUtf8 { .. } | Self::TooLarge { .. } | Self::Empty => None,
            Self::BadXml { line, .. }
            | Self::DocumentType { line }
            | Self::TooDeep { line, .. }
            | Self::TooMany { line, .. }
            | Self::NotARobot { line, .. }
            | Self::Unexpanded { line, .. }
            | Self::MissingAttribute { line, .. }
            | Self::MissingElement { line, .. }
            | Self::EmptyName { line, .. }
            | Self::NotANumber { line, .. }
            | Self::NotFinite { line, .. }
            | Self::TooBig { line, .. }
            | Self::WrongCount { line, .. }
            | Self::Negative { line, .. }
            | Self::Both { line, .. }
            | Self::ZeroQuaternion { line, .. }
            | Self::UnknownJointType { line, .. }
            | Self::ZeroAxis { line, .. }
            | Self::NoLinks { line, .. }
            | Self::DuplicateName { line, .. }
            | Self::UnknownLink { line, .. }
            | Self::SelfParent { line, .. }
            | Self::TwoParents { line, .. }
            | Self::Cycle { line, .. }
            | Self::MimicKind { line, .. }
            | Self::UnknownMimic { line, .. }
            | Self::MimicCycle { line, .. }
            | Self::Strict { line, .. } => Some(*line),
        }
    }

    /// The element at fault, as in `joint "elbow"/limit`; `None` where it is about the whole file.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::MissingAttribute { place, .. }
            | Self::MissingElement { place, .. }
            | Self::EmptyName { place, .. }
            | Self::NotANumber { place, .. }
            | Self::NotFinite { place, .. }
            | Self::TooBig { place, .. }
            | Self::WrongCount { place, .. }
            | Self::Negative { place, .. }
            | Self::Both { place, .. }
            | Self::ZeroQuaternion { place, .. }
            | Self::Strict { place, .. } => Some(place.clone()),
            Self::UnknownJointType { joint, .. }
            | Self::ZeroAxis { joint, .. }
            | Self::UnknownLink { joint, .. }
            | Self::SelfParent { joint, .. }
            | Self::MimicKind { joint, .. }
            | Self::UnknownMimic { joint, .. } => Some(format!("joint {joint:?}")),
            Self::DuplicateName { what, name, .. } => Some(format!("{what} {name:?}")),
            Self::TwoParents { link, .. } => Some(format!("link {link:?}")),
            Self::Cycle { joints, .. } | Self::MimicCycle { joints, .. } => {
                joints.first().map(|joint| format!("joint {joint}"))
            }
            _ => None,
        }
    }

    /// Always [`Severity::Error`].
    pub fn severity(&self) -> Severity {
        Severity::Error
    }
}

impl From<XmlError> for UrdfError {
    fn from(error: XmlError) -> Self {
        match error {
            XmlError::Unreadable { path, source } => Self::Unreadable { path, source },
            XmlError::NotUtf8 { byte } => Self::NotUtf8 { byte },
            XmlError::TooLarge { limit } => Self::TooLarge { limit },
            XmlError::Empty => Self::Empty,
            XmlError::DocumentType { line } => Self::DocumentType { line },
            XmlError::TooDeep { line, limit } => Self::TooDeep { line, limit },
            XmlError::TooMany { line, what, limit } => Self::TooMany { line, what, limit },
            XmlError::BadXml { line, column, reason } => Self::BadXml { line, column, reason },
            other => Self::BadXml { line: 1, column: 1, reason: excerpt(&other.to_string()) },
        }
    }
}
