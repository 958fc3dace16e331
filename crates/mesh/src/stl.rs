//! Reads STL files, binary or text.

use nalgebra::Vector3;

use crate::triangles::{Triangles, point_of};

/// Reads an STL file. A binary file is recognized by its size, because many begin with `solid` like text
/// files.
pub(crate) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    let count = bytes.get(80..84).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    let size = count.map(|count| 84 + 50 * u64::from(count));
    let is_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if is_text && size != Some(bytes.len() as u64) {
        return text(bytes);
    }
    let Some(size) = size.filter(|&size| size <= bytes.len() as u64) else {
        let advice =
            "a text file begins with `solid`, a binary file with 80 bytes and the number of triangles";
        return Err(format!("invalid STL: the file ends too early; {advice}"));
    };
    let mut triangles = Triangles::default();
    let facets = bytes[84..].chunks_exact(50).take(((size - 84) / 50) as usize);
    for facet in facets {
        let first = triangles.points.len();
        for corner in facet[12..48].chunks_exact(12) {
            triangles.points.push(Vector3::from_fn(|k, _| {
                let word = &corner[4 * k..];
                f64::from(f32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            }));
        }
        triangles.faces.push([first, first + 1, first + 2]);
    }
    Ok(triangles)
}

/// Reads the text form, whose words may have any case and whose names any encoding. Each `facet` has three
/// lines `vertex x y z`.
fn text(bytes: &[u8]) -> Result<Triangles, String> {
    let mut triangles = Triangles::default();
    let mut corners = 0;
    for (line, text) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let invalid = |what: &str| format!("invalid STL: line {}: {what}", line + 1);
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(word) = words.next() else { continue };
        if word.eq_ignore_ascii_case(b"vertex") {
            let point = point_of(words);
            triangles.points.push(point.ok_or_else(|| invalid("a vertex needs three numbers"))?);
            corners += 1;
        } else if word.eq_ignore_ascii_case(b"endfacet") {
            if corners != 3 {
                return Err(invalid("a facet needs three vertices"));
            }
            let first = triangles.points.len() - 3;
            triangles.faces.push([first, first + 1, first + 2]);
            corners = 0;
        }
    }
    if corners > 0 {
        return Err("invalid STL: the file ends within a facet".into());
    }
    Ok(triangles)
}
