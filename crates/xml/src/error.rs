//! The errors of reading XML.

use std::path::PathBuf;

use thiserror::Error;

/// The reason for which a file or text is refused before its elements are read. `line` counts from 1.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The message of each variant names its fields.
pub enum XmlError {
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
    #[error("the file is empty; a robot file has one outermost element")]
    Empty,
    /// The text is not well-formed XML.
    #[error("line {line}, column {column}: not well-formed XML: {reason}")]
    BadXml { line: usize, column: usize, reason: String },
    /// A document type declaration, whose entities can expand a few bytes to gigabytes.
    #[error("line {line}: <!DOCTYPE …> is not supported, and entities are not expanded; delete it")]
    DocumentType { line: usize },
    /// Elements are nested too deeply.
    #[error("line {line}: elements are nested deeper than {limit}")]
    TooDeep { line: usize, limit: usize },
    /// Too many attributes on an element, or too many namespace declarations.
    #[error("line {line}: more than {limit} {what}; this is not a robot file")]
    TooMany { line: usize, what: &'static str, limit: usize },
}

impl XmlError {
    /// The line of the error, from 1; `None` for errors of the whole file.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_xml::XmlError::DocumentType { line: 3 }.line(), Some(3));
    /// assert_eq!(robot_dynamics_xml::XmlError::Empty.line(), None);
    /// ```
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Unreadable { .. }
            | Self::NotText { .. }
            | Self::UnknownEncoding { .. }
            | Self::OtherFormat { .. }
            | Self::TooLarge { .. }
            | Self::Empty => None,
            Self::BadXml { line, .. }
            | Self::DocumentType { line }
            | Self::TooDeep { line, .. }
            | Self::TooMany { line, .. } => Some(*line),
        }
    }
}

/// At most 60 characters of a text, for a message.
///
/// ```
/// assert_eq!(robot_dynamics_xml::excerpt("elbow"), "elbow");
/// assert_eq!(robot_dynamics_xml::excerpt(&"x".repeat(100)).chars().count(), 61);
/// ```
pub fn excerpt(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
