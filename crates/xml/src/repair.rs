//! Repairs faults of XML that occur in robot files and that other readers accept.
//!
//! - Undeclared prefixes, as in `<drake:joint>` without `xmlns:drake`. Other readers take the prefix as a
//!   part of the name. The repair declares the prefix on the outermost element.
//! - An XML declaration `<?xml … ?>` that is not at the start of the file. The repair replaces it by blanks.
//! - Incorrect markup: see [`markup`].
//!
//! The line numbers stay the same.

use roxmltree::{Document, Error, TextPos};

use crate::{XmlError, markup, scan};

/// The largest number of repairs in a file.
const REPAIR_LIMIT: usize = 20;

/// A repaired text.
pub(crate) struct RepairedXml {
    pub(crate) text: String,
    /// The line of each fault, and a message.
    pub(crate) faults: Vec<(usize, String)>,
}

/// Repairs a text that the parser refuses, as far as its faults are known.
///
/// # Errors
/// [`XmlError`] if the text is hostile behind its first fault.
pub(crate) fn repair(original: &str, depth: usize) -> Result<RepairedXml, XmlError> {
    let (mut text, mut faults) = markup::correct(original);
    scan::refuse_hostile(&text, depth)?;
    for _ in 0..REPAIR_LIMIT {
        let Err(error) = Document::parse(&text) else { break };
        let Some(fault) = repair_one(&mut text, error) else { break };
        faults.push(fault);
    }
    Ok(RepairedXml { text, faults })
}

/// Repairs this error of the parser; returns its line and a message, or `None` if the error is of another
/// kind.
fn repair_one(text: &mut String, error: Error) -> Option<(usize, String)> {
    match error {
        Error::UnknownNamespace(prefix, position) => {
            let end = end_of_first_name(text)?;
            text.insert_str(end, &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""));
            let prefix = crate::excerpt(&prefix);
            let message = format!(
                "the prefix `{prefix}:` is not declared: taken as that of a foreign namespace; add \
                 xmlns:{prefix}=\"…\" to the outermost element"
            );
            Some((position.row as usize, message))
        }
        Error::UnexpectedDeclaration(position) => {
            let start = byte_of(text, position)?;
            let end = start + text[start..].find("?>")? + 2;
            let blank: String = text[start..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
            text.replace_range(start..end, &blank);
            let message = "<?xml … ?> is not at the start of the file: ignored; move it to the first byte, or \
                           delete it";
            Some((position.row as usize, message.to_owned()))
        }
        _ => None,
    }
}

/// The byte of the first `<?xml` after the position of the error.
fn byte_of(text: &str, position: TextPos) -> Option<usize> {
    let line: usize = text.split_inclusive('\n').take(position.row as usize - 1).map(str::len).sum();
    Some(line + text[line..].find("<?xml")?)
}

/// The name of the outermost element, without a prefix. The result for a text that is not XML is unspecified.
///
/// ```
/// assert_eq!(robot_dynamics_xml::outermost("<?xml version='1.0'?><!-- <a> --><mujoco model='m'/>"), Some("mujoco"));
/// assert_eq!(robot_dynamics_xml::outermost("no XML"), None);
/// ```
pub fn outermost(text: &str) -> Option<&str> {
    let end = end_of_first_name(text)?;
    let start = text[..end].rfind('<')? + 1;
    let name = &text[start..end];
    Some(name.rsplit_once(':').map_or(name, |(_, name)| name))
}

/// The byte after the name of the outermost element.
fn end_of_first_name(text: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        let length = if let Some(comment) = rest.strip_prefix("<!--") {
            4 + comment.find("-->")? + 3
        } else if rest.starts_with("<?") {
            rest.find("?>")? + 2
        } else {
            let name =
                rest[1..].find(|letter: char| letter.is_whitespace() || letter == '>' || letter == '/')?;
            return Some(at + 1 + name);
        };
        at += length;
    }
}
