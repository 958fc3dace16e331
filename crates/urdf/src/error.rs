//! The reasons for which a URDF file is refused.

use std::path::PathBuf;

use robot_dynamics_description::{LoadReport, RefusedFile, Severity};
use robot_dynamics_xml::{XmlError, excerpt};
use thiserror::Error;

/// A refused URDF file: all of its errors, in the order of its lines.
///
/// ```
/// let text = r#"<robot name="r"><link name="a"/><link name="a"/>
///     <joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint></robot>"#;
/// let refused = robot_dynamics_urdf::parse(text, &robot_dynamics_urdf::LoadOptions::default()).unwrap_err();
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

/// One error of a URDF file, with its place and advice.
///
/// `line` counts from 1; `place` is the element, as in `joint "elbow"/limit`.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The message of each variant names its fields.
pub enum UrdfError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    /// The file is not text in the encoding that it declares, or in UTF-8.
    #[error("byte {byte} is not {encoding}; save the file as UTF-8, and check that it is a robot file")]
    NotText { byte: usize, encoding: String },
    /// The XML declaration names an unknown encoding.
    #[error("the declared encoding {encoding:?} is unknown; save the file as UTF-8")]
    UnknownEncoding { encoding: String },
    /// The file has another format.
    #[error("this is {format}: {advice}")]
    OtherFormat { format: &'static str, advice: &'static str },
    /// The file is larger than the limit.
    #[error("the file has more than {limit} bytes, the largest size of a robot file")]
    TooLarge { limit: usize },
    /// The file is empty.
    #[error("the file is empty; a URDF file has one <robot> element")]
    Empty,
    /// The text is not well-formed XML.
    #[error("line {line}, column {column}: not well-formed XML: {reason}")]
    BadXml { line: usize, column: usize, reason: String },
    /// A document type declaration, whose entities can expand a few bytes to gigabytes.
    #[error("line {line}: <!DOCTYPE …> is not supported, and entities are not expanded; delete it")]
    DocumentType { line: usize },
    /// Elements are nested too deeply.
    #[error("line {line}: elements are nested deeper than {limit}; a URDF file needs fewer than ten levels")]
    TooDeep { line: usize, limit: usize },
    /// Too many attributes or namespaces.
    #[error("line {line}: more than {limit} {what}; this is not a robot file")]
    TooMany { line: usize, what: &'static str, limit: usize },
    /// Well-formed XML of another kind.
    #[error("line {line}: the outermost element is <{found}>, not <robot>; {advice}")]
    NotARobot { line: usize, found: String, advice: &'static str },
    /// A name in an SRDF file that the robot or the file does not have. `near` advises another name.
    #[error("line {line}: {place}: {owner} has no {what} {name:?}; {near}")]
    UnknownName {
        line: usize,
        place: String,
        owner: &'static str,
        what: &'static str,
        name: String,
        near: String,
    },
    /// A statement of an SRDF file that has no meaning for the robot.
    #[error("line {line}: {place}: {reason}")]
    BadSemantics { line: usize, place: String, reason: String },
    /// A URDF file where an SRDF file belongs.
    #[error("line {line}: <{found}> belongs to URDF; give the SRDF file, which has <disable_collisions>")]
    NotSrdf { line: usize, found: String },

    /// A xacro file that has not been expanded to URDF.
    #[error(
        "line {line}: this xacro file is not expanded (`xacro:{instruction}`, instructions in all: {count}): run `xacro \
         {file} > robot.urdf` with the arguments of the robot, and load robot.urdf; xacro is part of ROS; without ROS, \
         run `pip install xacrodoc` and `xacrodoc {file} -o robot.urdf`"
    )]
    Unexpanded { line: usize, instruction: String, count: usize, file: String },

    /// A required attribute is missing.
    #[error("line {line}: {place}: the attribute `{attribute}` is missing; write {example}")]
    MissingAttribute { line: usize, place: String, attribute: String, example: String },
    /// A required element is missing.
    #[error("line {line}: {place}: the element <{element}> is missing; {advice}")]
    MissingElement { line: usize, place: String, element: &'static str, advice: &'static str },
    /// A blank name.
    #[error("line {line}: {place}: the attribute `{attribute}` is empty; give a name")]
    EmptyName { line: usize, place: String, attribute: String },
    /// Text where a number belongs.
    #[error("line {line}: {place}: {attribute}={text:?} is not a number{advice}")]
    NotANumber { line: usize, place: String, attribute: String, text: String, advice: &'static str },
    /// NaN, infinity, or a number that overflows a double.
    #[error("line {line}: {place}: {attribute}={text:?} is not a finite number; {advice}")]
    NotFinite { line: usize, place: String, attribute: String, text: String, advice: &'static str },
    /// A number larger than any length, mass or inertia.
    #[error("line {line}: {place}: {attribute}={text:?} is larger than 1e30; use SI units (m, kg, s, rad)")]
    TooBig { line: usize, place: String, attribute: String, text: String },
    /// Too few or too many numbers in a list.
    #[error("line {line}: {place}: {attribute}={text:?} has {found} numbers instead of {expected}")]
    WrongCount { line: usize, place: String, attribute: String, text: String, expected: usize, found: usize },
    /// A negative value of a quantity that cannot be negative.
    #[error("line {line}: {place}: {attribute}={value} is negative; {advice}")]
    Negative { line: usize, place: String, attribute: String, value: f64, advice: &'static str },
    /// Two attributes for one quantity.
    #[error("line {line}: {place}: both `{first}` and `{second}` are given; keep one of them")]
    Both { line: usize, place: String, first: &'static str, second: &'static str },
    /// A quaternion of length zero.
    #[error("line {line}: {place}: quat_xyzw is zero; write \"0 0 0 1\" for no rotation")]
    ZeroQuaternion { line: usize, place: String },

    /// An unknown joint type.
    #[error(
        "line {line}: joint {joint:?}: the type {found:?} is unknown; use revolute, continuous, prismatic, fixed, \
         floating, planar or spherical"
    )]
    UnknownJointType { line: usize, joint: String, found: String },
    /// An axis of length zero.
    #[error("line {line}: joint {joint:?}: the axis is zero; give a direction such as xyz=\"0 0 1\"")]
    ZeroAxis { line: usize, joint: String },

    /// A robot without links.
    #[error("line {line}: robot {robot:?} has no links; a robot has at least one <link name=\"…\"/>")]
    NoLinks { line: usize, robot: String },
    /// A name that is used twice.
    #[error("line {line}: {what} {name:?} is already defined on line {first}; give each its own name")]
    DuplicateName { line: usize, what: &'static str, name: String, first: usize },
    /// A joint to or from a link that does not exist.
    #[error(
        "line {line}: joint {joint:?}: its {role} link {link:?} does not exist; add it or correct the name"
    )]
    UnknownLink { line: usize, joint: String, role: &'static str, link: String },
    /// A joint from a link to itself.
    #[error("line {line}: joint {joint:?} joins link {link:?} to itself; parent and child must differ")]
    SelfParent { line: usize, joint: String, link: String },
    /// A link that is the child of two joints.
    #[error(
        "line {line}: link {link:?} is the child of joint {joint:?} and of joint {first_joint:?} (line {first}); \
         a link has at most one parent joint, because URDF has no loops"
    )]
    TwoParents { line: usize, link: String, joint: String, first_joint: String, first: usize },
    /// A cycle of joints.
    #[error(
        "line {line}: the joints {} form a cycle; remove one of them, so that there is a root link",
        joints.join(" → ")
    )]
    Cycle { line: usize, joints: Vec<String> },

    /// A mimic joint or its leader does not have one degree of freedom.
    #[error(
        "line {line}: joint {joint:?} mimics {leader:?}, but {which} is {kind}; both must be revolute, continuous \
         or prismatic"
    )]
    MimicKind { line: usize, joint: String, leader: String, which: String, kind: &'static str },
    /// The leader of a mimic joint does not exist.
    #[error(
        "line {line}: joint {joint:?} mimics {leader:?}, which does not exist; add it or correct the name"
    )]
    UnknownMimic { line: usize, joint: String, leader: String },
    /// A cycle of mimic joints.
    #[error(
        "line {line}: the joints {} mimic each other in a cycle; remove <mimic> from one of them",
        joints.join(" → ")
    )]
    MimicCycle { line: usize, joints: Vec<String> },

    /// An error in an included file.
    #[error("{file}{source}")]
    InFile { file: String, source: Box<UrdfError> },
    /// A warning in a strict reading.
    #[error("line {line}: {place}: {message} (a warning, which a strict reading refuses)")]
    Strict { line: usize, place: String, message: String },
}

impl UrdfError {
    /// The line by which errors are sorted. A limit on the whole file comes first, so that it is always among
    /// the listed errors.
    pub(crate) fn sorted_at(&self) -> Option<usize> {
        if matches!(self, Self::TooMany { .. }) { None } else { self.line() }
    }

    /// The line of the error, from 1; `None` for errors of the whole file.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Unreadable { .. }
            | Self::NotText { .. }
            | Self::UnknownEncoding { .. }
            | Self::OtherFormat { .. }
            | Self::TooLarge { .. }
            | Self::Empty
            | Self::InFile { .. } => None,
            Self::BadXml { line, .. }
            | Self::DocumentType { line }
            | Self::TooDeep { line, .. }
            | Self::TooMany { line, .. }
            | Self::NotARobot { line, .. }
            | Self::NotSrdf { line, .. }
            | Self::UnknownName { line, .. }
            | Self::BadSemantics { line, .. }
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

    /// The element of the error, as in `joint "elbow"/limit`; `None` for errors of the whole file.
    pub fn place(&self) -> Option<String> {
        match self {
            Self::InFile { file, source } => source.place().map(|place| format!("{file}{place}")),
            Self::MissingAttribute { place, .. }
            | Self::UnknownName { place, .. }
            | Self::BadSemantics { place, .. }
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
            XmlError::NotText { byte, encoding } => Self::NotText { byte, encoding },
            XmlError::UnknownEncoding { encoding } => Self::UnknownEncoding { encoding },
            XmlError::OtherFormat { format, advice } => Self::OtherFormat { format, advice },
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
