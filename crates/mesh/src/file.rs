//! Reads mesh files: STL, OBJ and MuJoCo's MSH. Coordinates have single precision.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use nalgebra::Vector3;

use crate::polygon::add_triangles;

/// The largest size of a mesh file in bytes.
const SIZE_LIMIT: u64 = 1 << 29;

/// A mesh as in its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Points, in the units of the file.
    pub points: Vec<Vector3<f64>>,
    /// Triangles as indices of points, counter-clockwise from outside; empty for a file of points.
    pub faces: Vec<[usize; 3]>,
}

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
    let file = File::open(path).map_err(|error| format!("cannot read {shown}: {error}"))?;
    if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Err(format!("{shown} is not a regular file"));
    }
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
        (Some("model/stl"), _) | (None, "stl") => Ok(stl),
        (Some("model/obj"), _) | (None, "obj") => Ok(obj),
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

/// Checks that a mesh has points, that they are finite, and that the faces refer to existing points.
///
/// # Errors
/// A message about the first violation.
///
/// ```
/// use nalgebra::Vector3;
/// let faces = vec![[0, 1, 2]];
/// let mesh = robot_dynamics_mesh::Triangles { points: vec![Vector3::zeros(); 2], faces };
/// assert_eq!(robot_dynamics_mesh::check(&mesh).unwrap_err(), "triangle [0, 1, 2] refers to missing points (2 points)");
/// ```
pub fn check(triangles: &Triangles) -> Result<(), String> {
    let Triangles { points, faces } = triangles;
    if let Some(at) = points.iter().position(|point| point.iter().any(|x| !x.is_finite())) {
        return Err(format!("point {at} is not finite"));
    }
    if let Some(face) = faces.iter().find(|face| face.iter().any(|&corner| corner >= points.len())) {
        return Err(format!("triangle {face:?} refers to missing points ({} points)", points.len()));
    }
    if points.is_empty() { Err("it has no points".into()) } else { Ok(()) }
}

/// Reads STL, binary or text. A binary file is recognized by its size, because many begin with `solid` like
/// text files.
fn stl(mut bytes: Vec<u8>) -> Result<Triangles, String> {
    if let Some(count) = bytes.get(80..84) {
        let count = u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
        if bytes.len() as u64 == 84 + 50 * count {
            bytes[..80].fill(0);
        }
    }
    let mut bytes = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut bytes).map_err(|error| format!("invalid STL: {error}"))?;
    let mut triangles = Triangles::default();
    for triangle in reader {
        let triangle = triangle.map_err(|error| format!("invalid STL: {error}"))?;
        let first = triangles.points.len();
        triangles
            .points
            .extend(triangle.vertices.iter().map(|corner| Vector3::from(corner.0.map(f64::from))));
        triangles.faces.push([first, first + 1, first + 2]);
    }
    Ok(triangles)
}

fn obj(bytes: Vec<u8>) -> Result<Triangles, String> {
    let options = tobj::LoadOptions { ignore_lines: true, ignore_points: true, ..Default::default() };
    // Materials are not read.
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| Err(tobj::LoadError::OpenFileFailed))
            .map_err(|error| format!("invalid OBJ: {error}"))?;
    let mut triangles = Triangles::default();
    for tobj::Model { mesh, .. } in models {
        let first = triangles.points.len();
        triangles
            .points
            .extend(mesh.positions.chunks_exact(3).map(|x| Vector3::from_fn(|k, _| f64::from(x[k]))));
        let corners: Vec<usize> = mesh.indices.iter().map(|&corner| first + corner as usize).collect();
        if corners.iter().any(|&corner| corner >= triangles.points.len()) {
            return Err("invalid OBJ: a face refers to missing points".into());
        }
        if mesh.face_arities.is_empty() {
            triangles.faces.extend(corners.chunks_exact(3).map(|face| [face[0], face[1], face[2]]));
            continue;
        }
        let mut rest = &corners[..];
        for arity in mesh.face_arities {
            let Some((polygon, others)) = rest.split_at_checked(arity as usize) else { break };
            rest = others;
            add_triangles(polygon, &triangles.points, &mut triangles.faces);
        }
    }
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
