//! Prefixes that a file uses without declaring them, as in `<drake:joint>` without `xmlns:drake`.
//!
//! Files in use have them, and other readers take the prefix for a part of the name. Here each is declared on the
//! outermost element, on its line, so that the elements are foreign ones and all lines stay what they are.

use roxmltree::{Document, Error};

/// Files with more undeclared prefixes than this are no robot files.
const MOST: usize = 20;

/// Text whose prefixes are all declared.
pub(crate) struct Declared {
    pub(crate) text: String,
    /// Each prefix with the line of its first use.
    pub(crate) added: Vec<(String, usize)>,
}

/// Declares what is not declared; `None` when nothing is missing, or when that is not what is wrong.
pub(crate) fn declare(original: &str) -> Option<Declared> {
    let mut text = original.to_owned();
    let mut added = Vec::new();
    while let Err(Error::UnknownNamespace(prefix, position)) = Document::parse(&text) {
        let at = end_of_first_name(&text)?;
        if added.len() == MOST {
            return None;
        }
        text.insert_str(at, &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""));
        added.push((prefix, position.row as usize));
    }
    (!added.is_empty()).then_some(Declared { text, added })
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
