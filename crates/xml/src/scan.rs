//! Refuses hostile text before it is parsed.
//!
//! The scan follows tags, quotes, comments and CDATA as long as the text is well-formed. At the first fault
//! it stops, and the parser reports the error with its position.

use crate::{Resource, XmlError};

/// The largest number of attributes on one element. The parser compares all pairs of them.
const ATTRIBUTE_LIMIT: usize = 200;
/// The largest number of namespace declarations in a file. Elements inherit and copy them.
const NAMESPACE_LIMIT: usize = 100;

/// Refuses document type declarations, deep nesting, and large numbers of elements or attributes, in one
/// pass.
pub(crate) fn refuse_hostile(text: &str, depth_limit: usize) -> Result<(), XmlError> {
    let line_of = |at: usize| 1 + text[..at].matches('\n').count();
    let mut depth = 0_usize;
    let mut namespaces = 0;
    let mut elements = 0;
    let mut at = 0;
    while let Some(found) = text[at..].find('<') {
        let start = at + found;
        let rest = &text[start..];
        let end = if let Some(comment) = rest.strip_prefix("<!--") {
            comment.find("-->").map(|end| 4 + end + 3)
        } else if rest.starts_with("<![CDATA[") {
            rest.find("]]>").map(|end| end + 3)
        } else if rest.starts_with("<!") {
            return Err(XmlError::DocumentType { line: line_of(start) });
        } else if rest.starts_with("<?") {
            rest.find("?>").map(|end| end + 2)
        } else if rest.starts_with("</") {
            depth = depth.saturating_sub(1);
            rest.find('>').map(|end| end + 1)
        } else {
            let Some(tag) = Tag::at_start_of(rest) else { return Ok(()) };
            if tag.attributes > ATTRIBUTE_LIMIT {
                return Err(XmlError::TooMany {
                    line: line_of(start),
                    what: "attributes on one element",
                    limit: ATTRIBUTE_LIMIT,
                });
            }
            elements += 1;
            let limit = Resource::Elements.limit();
            if elements > limit.limit {
                let line = line_of(start);
                return Err(XmlError::TooMany { line, what: limit.what, limit: limit.limit });
            }
            namespaces += tag.namespaces;
            if namespaces > NAMESPACE_LIMIT {
                return Err(XmlError::TooMany {
                    line: line_of(start),
                    what: "namespace declarations",
                    limit: NAMESPACE_LIMIT,
                });
            }
            depth += usize::from(!tag.is_empty);
            if depth > depth_limit {
                return Err(XmlError::TooDeep { line: line_of(start), limit: depth_limit });
            }
            Some(tag.length)
        };
        match end {
            Some(length) => at = start + length,
            None => return Ok(()),
        }
    }
    Ok(())
}

/// An opening tag `<name a="…">` or an empty one `<name a="…"/>`.
struct Tag {
    length: usize,
    attributes: usize,
    namespaces: usize,
    is_empty: bool,
}

impl Tag {
    /// Scans the tag at the start of a text; `None` if it does not end.
    fn at_start_of(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        let (mut attributes, mut namespaces) = (0, 0);
        let mut at = 1;
        while at < bytes.len() {
            match bytes[at] {
                b'>' => {
                    let is_empty = bytes[at - 1] == b'/';
                    return Some(Self { length: at + 1, attributes, namespaces, is_empty });
                }
                quote @ (b'"' | b'\'') => {
                    at += 1 + bytes[at + 1..].iter().position(|&byte| byte == quote)?;
                }
                b'=' => attributes += 1,
                b'x' => namespaces += usize::from(bytes[at..].starts_with(b"xmlns")),
                _ => {}
            }
            at += 1;
        }
        None
    }
}
