//! Reads mesh files: STL, OBJ and MuJoCo's MSH. Coordinates have single precision.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use nalgebra::Vector3;

use crate::triangles::{Triangles, check};
use crate::{obj, stl};

/// The largest size of a mesh file in bytes.
const SIZE_LIMIT: u64 = 1 << 29;

/// Reads a mesh file. Its format is given by `content_type`, or else by the extension.
///
/// # Errors
/// A message with the path.
///
/// ```
/// let error = robot_dynamics_mesh::read("arm.dae".as_ref(), None).unwrap_err();
/// assert!(error.starts_with("arm.dae is not an STL, OBJ or MSH file"), "{error}");
/// ```
pub fn read(path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
    let shown = path.display();
    let read = reader(path, content_type)?;
    // A pipe is not opened, because this would wait for a writer.
    if std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(format!("{shown} is not a regular file"));
    }
    let file = File::open(path).map_err(|error| format!("cannot read {shown}: {error}"))?;
    let mut bytes = Vec::new();
    file.take(SIZE_LIMIT + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| format!("cannot read {shown}: {error}"))?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return Err(format!("{shown} has more than {SIZE_LIMIT} bytes"));
    }
    check_result(read(bytes), path)
}

/// Reads a mesh from the content of a file. `path` is not opened; it gives the format, as in [`read`].
///
/// # Errors
/// A message with the path.
///
/// ```
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// assert_eq!(robot_dynamics_mesh::parse(text, "flag.obj".as_ref(), None)?.faces, [[0, 1, 2]]);
/// # Ok::<(), String>(())
/// ```
pub fn parse(content: &[u8], path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
    check_result(reader(path, content_type)?(content.to_vec()), path)
}

/// A reader of one format.
type Reader = fn(Vec<u8>) -> Result<Triangles, String>;

fn reader(path: &Path, content_type: Option<&str>) -> Result<Reader, String> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match (content_type, extension.as_str()) {
        (Some("model/stl"), _) | (None, "stl") => Ok(|bytes| stl::read(&bytes)),
        (Some("model/obj"), _) | (None, "obj") => Ok(|bytes| obj::read(&bytes)),
        (Some("model/vnd.mujoco.msh"), _) | (None, "msh") => Ok(msh),
        _ => Err(format!(
            "{} is not an STL, OBJ or MSH file; convert it to one of these formats",
            path.display()
        )),
    }
}

fn check_result(read: Result<Triangles, String>, path: &Path) -> Result<Triangles, String> {
    let named = |reason: String| format!("{}: {reason}", path.display());
    let triangles = read.map_err(named)?;
    check(&triangles).map_err(named)?;
    Ok(triangles)
}

/// Reads MSH: four 32-bit counts (points, normals, texture points, faces), then points, normals and texture
/// points in single precision, then faces as indices.
#[allow(clippy::needless_pass_by_value)] // the same signature as the other readers
fn msh(bytes: Vec<u8>) -> Result<Triangles, String> {
    let words: Vec<[u8; 4]> =
        bytes.chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]).collect();
    let header: Option<Vec<usize>> = words
        .get(..4)
        .and_then(|words| words.iter().map(|word| usize::try_from(i32::from_le_bytes(*word)).ok()).collect());
    let Some(&[points, normals, texture, faces]) = header.as_deref() else {
        return Err("invalid MSH: it does not begin with four counts".into());
    };
    let expected = 4 + 3 * points + 3 * normals + 2 * texture + 3 * faces;
    if expected != words.len() || !bytes.len().is_multiple_of(4) {
        return Err(format!(
            "invalid MSH: {} bytes instead of the {} of its counts",
            bytes.len(),
            4 * expected
        ));
    }
    let real = |word: &[u8; 4]| f64::from(f32::from_le_bytes(*word));
    let corner = |word: &[u8; 4]| u32::from_le_bytes(*word) as usize;
    let rest = &words[4..];
    let (points, rest) = rest.split_at(3 * points);
    let faces = &rest[3 * normals + 2 * texture..];
    Ok(Triangles {
        points: points.chunks_exact(3).map(|x| Vector3::from_fn(|k, _| real(&x[k]))).collect(),
        faces: faces
            .chunks_exact(3)
            .map(|face| [corner(&face[0]), corner(&face[1]), corner(&face[2])])
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obj(text: &[u8]) -> Result<Triangles, String> {
        parse(text, Path::new("m.obj"), None)
    }

    const CORNERS: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

    #[test]
    fn points_of_an_obj_file_without_faces_are_kept() {
        let read = obj(CORNERS).unwrap();
        assert_eq!((read.points.len(), read.faces.len()), (4, 0));
        let read = obj(&[CORNERS, b"f 1 3 2\n"].concat()).unwrap();
        assert_eq!((read.points.len(), read.faces), (4, vec![[0, 1, 2]]));
        assert_eq!(read.points[3], Vector3::z());
    }

    #[test]
    fn names_in_an_obj_file_have_any_encoding() {
        let text = [b"o K\xf6rper\n", CORNERS, b"g \xff\xfe\nf 1/1/1 -2//2 2\n"].concat();
        assert_eq!(obj(&text).unwrap().faces.len(), 1);
    }

    #[test]
    fn all_objects_of_an_obj_file_are_one_mesh() {
        let text = [b"o a\n", CORNERS, b"f 1 2 3\no b\n", CORNERS, b"f 5 6 7 8\nf 1 5\n"].concat();
        let read = obj(&text).unwrap();
        assert_eq!((read.points.len(), read.faces.len()), (8, 3));
    }

    #[test]
    fn broken_obj_files_are_refused_with_their_line() {
        for (text, reason) in [
            ("v 1 2\n", "line 1: a point needs three numbers"),
            ("v 0 0 0\nf 1 x 1\n", "line 2: a face needs the numbers of its points"),
            ("v 0 0 0\nf 1 0 1\n", "line 2: a face needs the numbers of its points"),
            ("v 0 0 0\nf 1 -2 1\n", "line 2: a face needs the numbers of its points"),
            ("v 0 0 0\nf 1 2 1\n", "a face refers to missing points"),
        ] {
            assert_eq!(obj(text.as_bytes()).unwrap_err(), format!("m.obj: invalid OBJ: {reason}"));
        }
    }

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n";

    #[test]
    fn text_stl_files_of_all_spellings_are_read() {
        for text in [
            format!("solid\n{FACET}endsolid\n"),
            format!("solid name\n{FACET}endsolid name\n"),
            format!("SOLID NAME\n{}ENDSOLID\n", FACET.to_uppercase()),
            format!("  Solid\tname\r\n{}", FACET.replace('\n', "\r\n")),
        ] {
            let read = parse(text.as_bytes(), Path::new("m.stl"), None).unwrap();
            assert_eq!((read.points.len(), read.faces), (3, vec![[0, 1, 2]]), "{text}");
        }
        let name = [b"solid K\xf6rper\n", FACET.as_bytes()].concat();
        assert_eq!(parse(&name, Path::new("m.stl"), None).unwrap().faces.len(), 1);
        for (text, reason) in [
            ("solid\nfacet\nvertex 0 0\nendfacet".to_owned(), "line 3: a vertex needs three numbers"),
            ("solid\nfacet\nvertex 0 0 0\nendfacet".to_owned(), "line 4: a facet needs three vertices"),
            ("solid\nfacet\nvertex 0 0 0\n".to_owned(), "the file ends within a facet"),
        ] {
            let error = parse(text.as_bytes(), Path::new("m.stl"), None).unwrap_err();
            assert_eq!(error, format!("m.stl: invalid STL: {reason}"));
        }
    }
}
