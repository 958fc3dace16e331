//! Decodes the bytes of a file to text.

use std::borrow::Cow;

use encoding_rs::{DecoderResult, Encoding, UTF_8};

use crate::{XmlError, excerpt};

/// The text of a file: in the encoding of its byte order mark, as UTF-8, or in the encoding that its XML
/// declaration names. UTF-8 comes before the declaration, because editors convert files and leave the
/// declaration as it was. Text in another encoding is hardly ever valid UTF-8.
pub(crate) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, XmlError> {
    if let Some((encoding, mark)) = Encoding::for_bom(bytes).filter(|(encoding, _)| *encoding != UTF_8) {
        return decoded(encoding, bytes, mark);
    }
    let byte = match core::str::from_utf8(bytes) {
        Ok(text) => return Ok(Cow::Borrowed(text)),
        Err(error) => error.valid_up_to(),
    };
    let Some(name) = declared_encoding(bytes) else {
        return Err(XmlError::NotText { byte, encoding: UTF_8.name().to_owned() });
    };
    match encoding_named(&name) {
        Some(encoding) if encoding != UTF_8 => decoded(encoding, bytes, 0),
        Some(_) => Err(XmlError::NotText { byte, encoding: UTF_8.name().to_owned() }),
        None => Err(XmlError::UnknownEncoding { encoding: excerpt(&name) }),
    }
}

/// The encoding of this name, also in the spelling of names such as `latin-1`.
fn encoding_named(name: &str) -> Option<&'static Encoding> {
    Encoding::for_label(name.as_bytes()).or_else(|| Encoding::for_label(name.replace('-', "").as_bytes()))
}

/// Decodes the bytes after the first `mark` ones. Errors count from the start.
fn decoded(encoding: &'static Encoding, bytes: &[u8], mark: usize) -> Result<Cow<'static, str>, XmlError> {
    let bytes = &bytes[mark..];
    let mut decoder = encoding.new_decoder_without_bom_handling();
    let mut text = String::new();
    text.reserve(decoder.max_utf8_buffer_length_without_replacement(bytes.len()).unwrap_or(0));
    match decoder.decode_to_string_without_replacement(bytes, &mut text, true) {
        (DecoderResult::Malformed(bad, after), read) => {
            let byte = mark + read.saturating_sub(usize::from(bad) + usize::from(after));
            Err(XmlError::NotText { byte, encoding: encoding.name().to_owned() })
        }
        _ => Ok(Cow::Owned(text)),
    }
}

/// The name in `<?xml … encoding="NAME" … ?>`.
fn declared_encoding(bytes: &[u8]) -> Option<String> {
    let start: String = bytes.iter().take(200).map(|&byte| char::from(byte)).collect();
    let declaration = &start[start.find("<?xml")?..];
    let declaration = &declaration[..declaration.find("?>")?];
    let value = declaration[declaration.find("encoding")? + 8..].trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    value[1..].split(quote).next().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A declaration, then these bytes.
    fn declared(encoding: &str, bytes: &[u8]) -> Vec<u8> {
        [format!("<?xml version=\"1.0\" encoding='{encoding}' ?>").as_bytes(), bytes].concat()
    }

    #[test]
    fn the_declared_encoding_is_read() {
        for (encoding, bytes, text) in [
            ("ISO-8859-1", &[0xfc][..], "ü"),
            ("latin-1", &[0xfc], "ü"),
            ("windows-1252", &[0x80], "€"),
            ("GBK", &[0xb1, 0xdb], "臂"),
            ("Shift_JIS", &[0x98, 0x72], "腕"),
            ("UTF-8", "臂".as_bytes(), "臂"),
            // The declaration of a file that was converted to UTF-8.
            ("GBK", "臂".as_bytes(), "臂"),
        ] {
            let bytes = declared(encoding, bytes);
            let read = decode(&bytes).unwrap_or_else(|error| panic!("{encoding}: {error}"));
            assert!(read.ends_with(&format!("?>{text}")), "{encoding}: {read}");
        }
        let utf16: Vec<u8> = "\u{feff}<a/>".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(decode(&utf16).expect("a text"), "<a/>");
    }

    #[test]
    fn errors_name_the_encoding_and_the_byte() {
        let start = declared("", &[]).len();
        let error = |encoding: &str, bytes: &[u8]| decode(&declared(encoding, bytes)).expect_err(encoding);
        let expected = |encoding: &str, name: &str, at: usize| {
            let found = error(encoding, b"12\xff");
            let byte = start + encoding.len() + at;
            assert!(
                matches!(&found, XmlError::NotText { byte: b, encoding } if *b == byte && encoding == name),
                "{found:?}, {byte}"
            );
        };
        expected("GBK", "GBK", 2);
        expected("utf-8", "UTF-8", 2);
        assert!(
            matches!(error("klingon", b"\xff"), XmlError::UnknownEncoding { encoding } if encoding == "klingon")
        );
        assert!(matches!(decode(b"12\xff"), Err(XmlError::NotText { byte: 2, .. })));
        // A low surrogate alone, after the mark and one letter.
        let half = [0xff, 0xfe, b'a', 0, 0x00, 0xdc, b'b', 0];
        let found = decode(&half).expect_err("half a pair");
        assert!(
            matches!(&found, XmlError::NotText { byte: 4, encoding } if encoding == "UTF-16LE"),
            "{found:?}"
        );
    }
}
