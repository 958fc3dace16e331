//! Checks of the content of a file before it is parsed.

use crate::{binary, paths};

/// The deepest nesting of braces, brackets and parentheses in text. Nested bodies take one each.
pub(crate) const DEPTH_LIMIT: usize = 256;

/// Whether the content is that of a USD file: text, binary, or an archive of a USD file.
///
/// ```
/// assert!(robot_dynamics_usd::is_usd(b"#usda 1.0\n"));
/// assert!(!robot_dynamics_usd::is_usd(b"<robot name='r'/>"));
/// ```
pub fn is_usd(content: &[u8]) -> bool {
    let content = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content);
    content.starts_with(b"#usda") || content.starts_with(b"PXR-USDC") || is_archive_of_usd(content)
}

/// The first file of an archive is the main one.
fn is_archive_of_usd(content: &[u8]) -> bool {
    if !content.starts_with(b"PK\x03\x04") || content.len() < 30 {
        return false;
    }
    let length = usize::from(u16::from_le_bytes([content[26], content[27]]));
    let name = content.get(30..30 + length).unwrap_or_default();
    [".usd", ".usda", ".usdc"].iter().any(|end| name.to_ascii_lowercase().ends_with(end.as_bytes()))
}

/// Refuses text that is nested too deeply, names and paths at which openusd does not end, and binary files
/// whose tables do not fit.
pub(crate) fn check(content: &[u8]) -> Result<(), String> {
    if content.starts_with(b"PXR-USDC") {
        return binary::check(content);
    }
    if content.starts_with(b"PK") {
        return Ok(());
    }
    check_text(content)
}

/// The next word or string, after the words before it.
#[derive(Clone, Copy, PartialEq)]
enum Expected {
    Anything,
    /// After `def`, `over` or `class`: a type, or the name of a prim.
    TypeOrName,
    /// After the type of a prim: its name.
    Name,
}

/// Checks the tokens of a text, which openusd separates in the same way.
fn check_text(content: &[u8]) -> Result<(), String> {
    let mut depth = 0_usize;
    let mut expected = Expected::Anything;
    let mut at = 0;
    while at < content.len() {
        let start = at;
        let unclosed = |what: &str| format!("byte {start}: {what} that starts here does not end");
        match content[at] {
            b' ' | b'\t' | b'\r' | b'\n' | b'\x0c' => at += 1,
            b'#' => at += content[at..].iter().take_while(|byte| !b"\r\n".contains(byte)).count(),
            b'/' if content[at..].starts_with(b"/*") => {
                at = end_after(content, at + 2, b"*/").ok_or_else(|| unclosed("the comment"))?;
            }
            quote @ (b'"' | b'\'') => {
                let (name, end) = string(content, at, quote).ok_or_else(|| unclosed("the string"))?;
                if expected != Expected::Anything {
                    paths::check_prim_name(name)?;
                }
                (expected, at) = (Expected::Anything, end);
            }
            b'<' => {
                at = end_after(content, at + 1, b">").ok_or_else(|| unclosed("the path"))?;
                paths::check_path(&content[start + 1..at - 1])?;
            }
            b'@' => {
                let mark: &[u8] = if content[at..].starts_with(b"@@@") { b"@@@" } else { b"@" };
                let end = end_after(content, at + mark.len(), mark);
                at = end.ok_or_else(|| unclosed("the name of a file"))?;
            }
            byte if byte == b'_' || byte.is_ascii_alphabetic() => {
                let is_in_word = |byte: &&u8| byte.is_ascii_alphanumeric() || b"_:".contains(byte);
                at += content[at..].iter().take_while(is_in_word).count();
                expected = match (&content[start..at], expected) {
                    (b"def" | b"over" | b"class", _) => Expected::TypeOrName,
                    (_, Expected::TypeOrName) => Expected::Name,
                    _ => Expected::Anything,
                };
            }
            byte => {
                depth = match byte {
                    b'{' | b'[' | b'(' => depth + 1,
                    b'}' | b']' | b')' => depth.saturating_sub(1),
                    _ => depth,
                };
                if depth > DEPTH_LIMIT {
                    return Err(format!("braces are nested deeper than {DEPTH_LIMIT}"));
                }
                (expected, at) = (Expected::Anything, at + 1);
            }
        }
    }
    Ok(())
}

/// The place after the next closing mark.
fn end_after(content: &[u8], from: usize, mark: &[u8]) -> Option<usize> {
    let found = content.get(from..)?.windows(mark.len()).position(|window| window == mark)?;
    Some(from + found + mark.len())
}

/// The content of the string that starts here, and the place after it. Strings in three quotes have no
/// escapes.
fn string(content: &[u8], start: usize, quote: u8) -> Option<(&[u8], usize)> {
    if content[start..].starts_with(&[quote; 3]) {
        let end = end_after(content, start + 3, &[quote; 3])?;
        return Some((&content[start + 3..end - 3], end));
    }
    let mut at = start + 1;
    while at < content.len() {
        match content[at] {
            b'\\' => at += 1,
            byte if byte == quote => return Some((&content[start + 1..at], at + 1)),
            _ => {}
        }
        at += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deep_nesting_is_refused() {
        let deep = "{".repeat(257);
        assert!(check(deep.as_bytes()).is_err());
        assert!(check(format!("\"{deep}\" @{deep}@ 'a\nb' /* {deep} */").as_bytes()).is_ok());
        // Triple quotes have no escapes, and a quote in a comment starts no string.
        assert!(check(format!("'''\\'''{deep}").as_bytes()).is_err());
        assert!(check(format!("# don't\n{deep}").as_bytes()).is_err());
    }

    #[test]
    fn names_and_paths_without_end_of_composition_are_refused() {
        for name in ["", ".", "a}", "a/b", "{", "a."] {
            for before in ["def", "over Xform", "class\t# a comment\n", "def /* } */ Xform"] {
                let text = format!("#usda 1.0\n{before} \"{name}\" {{}}");
                assert!(check(text.as_bytes()).is_err(), "{text}");
            }
        }
        assert!(check(b"def Xform 'arm_1' { string s = 'a}' \n rel r = </a{v=x}b> }").is_ok());
        assert!(check("def 'Ölarm' (doc = '''a}''') {}".as_bytes()).is_ok());
        for path in ["/a}", "//a", "/a}{"] {
            assert!(check(format!("def 'b' (inherits = <{path}>) {{}}").as_bytes()).is_err(), "{path}");
        }
    }

    #[test]
    fn parts_without_end_are_refused() {
        for text in ["'a", "\"\"\"a\"\"", "<a", "@a", "@@@a@", "/* *"] {
            assert!(check(text.as_bytes()).is_err(), "{text}");
        }
    }
}
