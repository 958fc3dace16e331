//! Reads and parses XML from a file or a string.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Error};

use crate::encoding::decode;
use crate::{XmlError, excerpt, format, repair, scan};

/// The largest size of a robot file in bytes.
pub const SIZE_LIMIT: usize = 1 << 26;

/// Reads the text of a file: UTF-8, or the encoding of its byte order mark or its XML declaration.
///
/// ```
/// let missing = robot_dynamics_xml::read_file("nowhere.xml".as_ref());
/// assert!(matches!(missing, Err(robot_dynamics_xml::XmlError::Unreadable { .. })));
/// ```
///
/// # Errors
/// [`XmlError`] if the file cannot be read, is too large, is not text, or has another format.
pub fn read_file(path: &Path) -> Result<String, XmlError> {
    text_of(&read_bytes(path)?)
}

/// Reads the content of a file up to [`SIZE_LIMIT`] and one byte more, from which [`text_of`] sees that it is
/// too large.
///
/// ```
/// let missing = robot_dynamics_xml::read_bytes("nowhere.usdc".as_ref());
/// assert!(matches!(missing, Err(robot_dynamics_xml::XmlError::Unreadable { .. })));
/// ```
///
/// # Errors
/// [`XmlError::Unreadable`] if the file cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, XmlError> {
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(SIZE_LIMIT as u64 + 1).read_to_end(&mut bytes))
        .map_err(|source| XmlError::Unreadable { path: path.to_owned(), source })?;
    Ok(bytes)
}

/// The spellings of a file's name that are tried: as written, and with `/` in place of `\`.
///
/// ```
/// let spellings: Vec<_> = robot_dynamics_xml::spellings(r"meshes\link.stl").collect();
/// assert_eq!(spellings.last().map(|path| path.ends_with("meshes/link.stl")), Some(true));
/// assert_eq!(robot_dynamics_xml::spellings("link.stl").count(), 1);
/// ```
pub fn spellings(name: &str) -> impl Iterator<Item = PathBuf> {
    let other = name.contains('\\').then(|| PathBuf::from(name.replace('\\', "/")));
    core::iter::once(PathBuf::from(name)).chain(other)
}

/// Reads the text of a file that another file names. It must be a regular file: a pipe or a device may never
/// end.
///
/// ```
/// let folder = robot_dynamics_xml::read_regular_file(std::path::Path::new("."));
/// assert!(folder.unwrap_err().to_string().contains("not a regular file"));
/// ```
///
/// # Errors
/// As [`read_file`], and for a file of another kind.
pub fn read_regular_file(path: &Path) -> Result<String, XmlError> {
    text_of(&read_regular_bytes(path)?)
}

/// Reads the content of a file that another file names, as [`read_bytes`]. It must be a regular file.
///
/// ```
/// let folder = robot_dynamics_xml::read_regular_bytes(std::path::Path::new("."));
/// assert!(folder.unwrap_err().to_string().contains("not a regular file"));
/// ```
///
/// # Errors
/// As [`read_bytes`], and for a file of another kind.
pub fn read_regular_bytes(path: &Path) -> Result<Vec<u8>, XmlError> {
    // A pipe is not opened, because this would wait for a writer.
    if std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        let source = std::io::Error::other("it is not a regular file");
        return Err(XmlError::Unreadable { path: path.to_owned(), source });
    }
    read_bytes(path)
}

/// Decodes the content of a file: UTF-8, or the encoding of its byte order mark or its XML declaration.
///
/// ```
/// assert_eq!(robot_dynamics_xml::text_of("größer".as_bytes())?, "größer");
/// assert!(robot_dynamics_xml::text_of(&[0xff]).is_err());
/// # Ok::<(), robot_dynamics_xml::XmlError>(())
/// ```
///
/// # Errors
/// [`XmlError`] if the content is too large, is not text, or has another format.
pub fn text_of(content: &[u8]) -> Result<String, XmlError> {
    if content.len() > SIZE_LIMIT {
        return Err(XmlError::TooLarge { limit: SIZE_LIMIT });
    }
    format::refuse_other_formats(content)?;
    decode(content).map(Cow::into_owned)
}

/// Parses a text and calls `read` with the document. Hostile text is refused, as are elements nested deeper
/// than `depth`. Faults of the XML that other readers accept are repaired: undeclared prefixes, an XML
/// declaration that is not at the start, `--` in comments, missing spaces between attributes, `&` and `<` as
/// characters. `read` also gets the line and a message for each kind of repaired fault.
///
/// ```
/// let name = |document: &robot_dynamics_xml::roxmltree::Document<'_>| document.root_element().tag_name().name().to_owned();
/// let read = robot_dynamics_xml::parse("<robot><drake:joint/></robot>", 200, |document, faults| (name(document), faults.len()))?;
/// assert_eq!(read, ("robot".to_owned(), 1)); // the prefix is not declared
/// # Ok::<(), robot_dynamics_xml::XmlError>(())
/// ```
///
/// # Errors
/// [`XmlError`] if the text is refused, or is not well-formed.
pub fn parse<R>(
    text: &str,
    depth: usize,
    read: impl for<'a> FnOnce(&'a Document<'a>, &[(usize, String)]) -> R,
) -> Result<R, XmlError> {
    if text.len() > SIZE_LIMIT {
        return Err(XmlError::TooLarge { limit: SIZE_LIMIT });
    }
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(XmlError::Empty);
    }
    format::refuse_other_formats(text.as_bytes())?;
    scan::refuse_hostile(text, depth)?;
    if let Ok(document) = Document::parse(text) {
        return Ok(read(&document, &[]));
    }
    let repaired = repair::repair(text, depth)?;
    let document = Document::parse(&repaired.text).map_err(|error| bad_xml(&error, &repaired.text))?;
    Ok(read(&document, &repaired.faults))
}

/// The error of the parser, without the position in its text. The position of an incomplete text is its end.
fn bad_xml(error: &Error, text: &str) -> XmlError {
    use Error::{NoRootNode, UnclosedRootNode, UnexpectedEndOfStream};
    let position = error.pos();
    let (line, column) = match error {
        NoRootNode | UnclosedRootNode | UnexpectedEndOfStream => {
            let last = text.lines().last().unwrap_or_default();
            (text.lines().count(), last.chars().count() + 1)
        }
        _ => (position.row as usize, position.col as usize),
    };
    let reason = excerpt(&error.to_string().replace(&format!(" at {position}"), ""));
    XmlError::BadXml { line, column, reason }
}
