//! XML that is not quite well-formed, but in use, and read by other readers: mended before it is parsed.
//!
//! - Prefixes that are not declared, as in `<drake:joint>` without `xmlns:drake`; other readers take the prefix for a
//!   part of the name. Each is declared on the outermost element.
//! - `<?xml … ?>` behind the start of the file: blanked.
//!
//! No line break comes or goes, so that all lines stay what they are.

use roxmltree::{Document, Error, TextPos};

/// Files with more to mend than this are no robot files.
const MOST: usize = 20;

/// Text that is well-formed in these respects.
pub(crate) struct Mended {
    pub(crate) text: String,
    /// The line of each fault, and what was wrong, what was taken, what to do.
    pub(crate) faults: Vec<(usize, String)>,
}

/// Text with this error of the parser mended, and those behind it; `None` when that is not what is wrong.
pub(crate) fn mend(original: &str, mut error: Error) -> Option<Mended> {
    let mut text = original.to_owned();
    let mut faults = Vec::new();
    while faults.len() < MOST {
        match error {
            Error::UnknownNamespace(prefix, position) => {
                text.insert_str(
                    end_of_first_name(&text)?,
                    &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""),
                );
                let prefix = crate::excerpt(&prefix);
                let message = format!(
                    "the prefix `{prefix}:` is not declared: taken as one of another program; add xmlns:{prefix}=\"…\" \
                     to <robot>"
                );
                faults.push((position.row as usize, message));
            }
            Error::UnexpectedDeclaration(position) => {
                let start = byte_of(&text, position)?;
                let end = start + text[start..].find("?>")? + 2;
                let blank: String =
                    text[start..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
                text.replace_range(start..end, &blank);
                let message = "<?xml … ?> is not at the start of the file: not read; move it to the first byte, or \
                               delete it";
                faults.push((position.row as usize, message.to_owned()));
            }
            _ => return None,
        }
        match Document::parse(&text) {
            Ok(_) => return Some(Mended { text, faults }),
            Err(next) => error = next,
        }
    }
    None
}

/// Where the next `<?xml` begins, from the position of the parser's complaint on.
fn byte_of(text: &str, position: TextPos) -> Option<usize> {
    let line: usize = text.split_inclusive('\n').take(position.row as usize - 1).map(str::len).sum();
    Some(line + text[line..].find("<?xml")?)
}

/// The name of the outermost element, without a prefix; of a text that is no XML whatever stands in its place.
///
/// ```
/// assert_eq!(robot_xml::outermost("<?xml version='1.0'?><!-- <a> --><mujoco model='m'/>"), Some("mujoco"));
/// assert_eq!(robot_xml::outermost("no XML"), None);
/// ```
pub fn outermost(text: &str) -> Option<&str> {
    let end = end_of_first_name(text)?;
    let start = text[..end].rfind('<')? + 1;
    let name = &text[start..end];
    Some(name.rsplit_once(':').map_or(name, |(_, name)| name))
}

/// The byte behind the name of the outermost element.
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
