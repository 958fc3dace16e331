//! Reads OBJ files: points and polygons of all objects and groups. Other data, such as materials, are
//! skipped.

use std::collections::HashMap;

use crate::polygon::Triangulation;
use crate::triangles::{Triangles, point_of};

/// Reads an OBJ file. Names in it may have any encoding. Points come in the order in which the faces use
/// them, and those without a face come last.
pub(crate) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    let mut written = Vec::new();
    let mut polygons: Vec<Vec<usize>> = Vec::new();
    for (line, text) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let invalid = |what: &str| format!("invalid OBJ: line {}: {what}", line + 1);
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                let point = point_of(words.take(3));
                written.push(point.ok_or_else(|| invalid("a point needs three numbers"))?);
            }
            Some(b"f") => {
                let polygon: Option<Vec<usize>> = words
                    .take_while(|word| word[0] != b'#')
                    .map(|word| corner(word, written.len()))
                    .collect();
                let polygon = polygon.ok_or_else(|| invalid("a face needs the numbers of its points"))?;
                // Fewer corners are a point or a line.
                if polygon.len() > 2 {
                    polygons.push(polygon);
                }
            }
            _ => {}
        }
    }
    if polygons.iter().flatten().any(|&corner| corner >= written.len()) {
        return Err("invalid OBJ: a face refers to missing points".into());
    }
    let mut triangles = Triangles::default();
    let mut places: HashMap<usize, usize> = HashMap::new();
    for corner in polygons.iter_mut().flatten() {
        let place = *places.entry(*corner).or_insert(triangles.points.len());
        if place == triangles.points.len() {
            triangles.points.push(written[*corner]);
        }
        *corner = place;
    }
    let mut triangulation = Triangulation::default();
    for polygon in &polygons {
        triangulation.add_triangles(polygon, &triangles.points, &mut triangles.faces)?;
    }
    let others = (0..written.len()).filter(|point| !places.contains_key(point));
    triangles.points.extend(others.map(|point| written[point]));
    Ok(triangles)
}

/// The index of the point in `point/texture/normal`. Negative numbers count from the last point before.
fn corner(word: &[u8], count: usize) -> Option<usize> {
    let number = word.split(|&byte| byte == b'/').next()?;
    let number: i64 = core::str::from_utf8(number).ok()?.parse().ok()?;
    match usize::try_from(number) {
        Ok(number) => number.checked_sub(1),
        Err(_) => count.checked_sub(usize::try_from(number.checked_neg()?).ok()?),
    }
}
