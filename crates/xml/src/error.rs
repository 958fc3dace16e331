//! Why a text is not one that a reader of robot files parses.

use std::path::PathBuf;

use thiserror::Error;

/// Why a text was refused before any element of it was read. `line` counts from 1.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The fields are the nouns of each variant's sentence.
pub enum XmlError {
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
    #[error("the file is empty; a robot file holds one outermost element")]
    Empty,
    /// The text is not well-formed XML.
    #[error("line {line}, column {column}: not well-formed XML: {reason}")]
    BadXml { line: usize, column: usize, reason: String },
    /// A document type declaration, by which a few bytes can expand to gigabytes.
    #[error("line {line}: a robot file needs no <!DOCTYPE …>, and its entities are not expanded; delete it")]
    DocumentType { line: usize },
    /// Elements nested beyond any robot file.
    #[error("line {line}: elements are nested deeper than {limit}")]
    TooDeep { line: usize, limit: usize },
    /// More attributes or namespaces on an element than any robot file has.
    #[error("line {line}: more than {limit} {what}; this is not a robot file")]
    TooMany { line: usize, what: &'static str, limit: usize },
}

impl XmlError {
    /// The line at fault, from 1; `None` where it is not about a line.
    ///
    /// ```
    /// assert_eq!(robot_xml::XmlError::DocumentType { line: 3 }.line(), Some(3));
    /// assert_eq!(robot_xml::XmlError::Empty.line(), None);
    /// ```
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Unreadable { .. } | Self::NotUtf8 { .. } | Self::TooLarge { .. } | Self::Empty => None,
            Self::BadXml { line, .. }
            | Self::DocumentType { line }
            | Self::TooDeep { line, .. }
            | Self::TooMany { line, .. } => Some(*line),
        }
    }
}

/// At most 60 characters of the file's text, for a message.
///
/// ```
/// assert_eq!(robot_xml::excerpt("elbow"), "elbow");
/// assert_eq!(robot_xml::excerpt(&"x".repeat(100)).chars().count(), 61);
/// ```
pub fn excerpt(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
