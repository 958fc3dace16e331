//! From a file or a string to parsed XML.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Error};

use crate::{XmlError, excerpt, scan, unclean_xml};

/// The most bytes that a robot file may have.
pub const SIZE_LIMIT: usize = 1 << 26;

/// The text of a file: UTF-8, or Latin-1 where its XML declaration says so.
///
/// ```
/// let missing = robot_xml::read_file("nowhere.xml".as_ref());
/// assert!(matches!(missing, Err(robot_xml::XmlError::Unreadable { .. })));
/// ```
///
/// # Errors
/// [`XmlError`] if the file cannot be read, is too large, or is no text.
pub fn read_file(path: &Path) -> Result<String, XmlError> {
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(SIZE_LIMIT as u64 + 1).read_to_end(&mut bytes))
        .map_err(|source| XmlError::Unreadable { path: path.to_owned(), source })?;
    text_of(&bytes)
}

/// The text of a file's content: UTF-8, or Latin-1 where its XML declaration says so.
///
/// ```
/// assert_eq!(robot_xml::text_of("größer".as_bytes())?, "größer");
/// assert!(robot_xml::text_of(&[0xff]).is_err());
/// # Ok::<(), robot_xml::XmlError>(())
/// ```
///
/// # Errors
/// [`XmlError`] if it is too large, or no text.
pub fn text_of(content: &[u8]) -> Result<String, XmlError> {
    if content.len() > SIZE_LIMIT {
        return Err(XmlError::TooLarge { limit: SIZE_LIMIT });
    }
    decoded(content).map(Cow::into_owned).map_err(|byte| XmlError::NotUtf8 { byte })
}

/// UTF-8, or Latin-1 where the XML declaration says so; else the first byte that is not UTF-8.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, usize> {
    core::str::from_utf8(bytes).map(Cow::Borrowed).or_else(|error| {
        let declaration = bytes.split(|&byte| byte == b'>').next().unwrap_or_default();
        let declaration = String::from_utf8_lossy(declaration).to_ascii_lowercase();
        let is_latin = ["iso-8859-1", "latin1", "latin-1"].iter().any(|name| declaration.contains(name));
        // The first 256 characters of Unicode are those of Latin-1.
        if is_latin {
            Ok(bytes.iter().map(|&byte| char::from(byte)).collect())
        } else {
            Err(error.valid_up_to())
        }
    })
}

/// Parses a text after refusing what is hostile, elements nested deeper than `depth` among it, and mending what is not
/// quite well-formed; then reads it. `read` also gets what was mended: the line of each fault, and what was wrong, what
/// was taken, what to do.
///
/// ```
/// let name = |document: &robot_xml::roxmltree::Document<'_>| document.root_element().tag_name().name().to_owned();
/// let read = robot_xml::parse("<robot><drake:joint/></robot>", 200, |document, faults| (name(document), faults.len()))?;
/// assert_eq!(read, ("robot".to_owned(), 1)); // the prefix is not declared
/// # Ok::<(), robot_xml::XmlError>(())
/// ```
///
/// # Errors
/// [`XmlError`] says what is wrong, and where.
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
    scan::refuse_hostile(text, depth)?;
    match Document::parse(text) {
        Ok(document) => Ok(read(&document, &[])),
        Err(error) => {
            let mended = unclean_xml::mend(text, error);
            let (text, faults) =
                mended.as_ref().map_or((text, &[][..]), |mended| (&mended.text[..], &mended.faults[..]));
            let document = Document::parse(text).map_err(|error| bad_xml(&error, text))?;
            Ok(read(&document, faults))
        }
    }
}

/// The parser's complaint with its position given once; text that just stops is wrong at its end.
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
