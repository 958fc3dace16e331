//! Checks of the content of a file before it is parsed.

use crate::binary;

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

/// Refuses text that is nested too deeply, and binary files with counts that do not fit.
pub(crate) fn check(content: &[u8]) -> Result<(), String> {
    if content.starts_with(b"PXR-USDC") {
        return binary::check(content);
    }
    if content.starts_with(b"PK") {
        return Ok(());
    }
    let mut depth = 0_usize;
    let mut at = 0;
    while at < content.len() {
        match content[at] {
            b'{' | b'[' | b'(' => {
                depth += 1;
                if depth > DEPTH_LIMIT {
                    return Err(format!("braces are nested deeper than {DEPTH_LIMIT}"));
                }
            }
            b'}' | b']' | b')' => depth = depth.saturating_sub(1),
            quote @ (b'"' | b'\'') => at = end_of_string(content, at, quote),
            _ => {}
        }
        at += 1;
    }
    Ok(())
}

/// The last byte of the string that starts here.
fn end_of_string(content: &[u8], start: usize, quote: u8) -> usize {
    let triple = content[start..].starts_with(&[quote; 3]);
    let mut at = start + if triple { 3 } else { 1 };
    while at < content.len() {
        match content[at] {
            b'\\' => at += 1,
            b'\n' if !triple => return start,
            byte if byte == quote && (!triple || content[at..].starts_with(&[quote; 3])) => {
                return at + if triple { 2 } else { 0 };
            }
            _ => {}
        }
        at += 1;
    }
    // An unclosed string hides nothing.
    start
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deep_nesting_is_refused() {
        assert!(check("{".repeat(257).as_bytes()).is_err());
        assert!(check(format!("\"{}\"", "{".repeat(257)).as_bytes()).is_ok());
    }
}
