//! Recognizes files of other formats by their first bytes.

use crate::XmlError;

/// The first bytes of a format, its name, and advice.
const FORMATS: [(&[u8], &str, &str); 13] = [
    (b"PXR-USDC", "USD", USD),
    (b"#usda", "USD", USD),
    // 54321, the first number of the header.
    (&[0x31, 0xd4, 0, 0], "a compiled MuJoCo model", MJB),
    (b"MJB", "a compiled MuJoCo model", MJB),
    (b"PK\x03\x04", "a ZIP archive", ARCHIVE),
    (&[0x1f, 0x8b], "a gzip archive", ARCHIVE),
    (b"glTF", "a glTF mesh", MESH),
    (b"solid", "an STL mesh", MESH),
    (b"ply", "a PLY mesh", MESH),
    (b"%PDF", "a PDF document", ROBOT),
    (b"\x89PNG", "a PNG image", ROBOT),
    (b"\x7fELF", "a program", ROBOT),
    (b"{", "JSON", ROBOT),
];
const ROBOT: &str = "load the robot's URDF or MJCF file";
const ARCHIVE: &str = "unpack it, and load the robot's URDF or MJCF file";
const USD: &str = "this program was built without its reader; export URDF or MJCF";
const MJB: &str = "load the XML file that it was compiled from, or save one with mj_saveLastXML";
const MESH: &str = "load the URDF or MJCF file that names it";

/// Refuses the content of a file whose first bytes are those of another format.
pub(crate) fn refuse_other_formats(content: &[u8]) -> Result<(), XmlError> {
    let found = FORMATS.iter().find(|(start, ..)| content.starts_with(start));
    found.map_or(Ok(()), |&(_, format, advice)| Err(XmlError::OtherFormat { format, advice }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_formats_are_named() {
        let message = |content: &[u8]| refuse_other_formats(content).expect_err("a message").to_string();
        assert_eq!(
            message(b"#usda 1.0\n("),
            "this is USD: this program was built without its reader; export URDF or MJCF"
        );
        assert!(message(&54321_i32.to_le_bytes()).contains("compiled MuJoCo model: load the XML file"));
        assert!(message(b"PK\x03\x04...").contains("ZIP archive: unpack it"));
        assert!(refuse_other_formats(b"\xef\xbb\xbf<?xml version=\"1.0\"?><robot/>").is_ok());
    }
}
