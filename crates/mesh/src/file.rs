//! Mesh files: STL, OBJ and MuJoCo's own MSH, as triangles whose corners are numbers of single precision.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use nalgebra::Vector3;

use crate::polygon::divide;

/// The most bytes that a mesh file may have.
const SIZE_LIMIT: u64 = 1 << 29;

/// A mesh as its file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Corners, in the file's units.
    pub points: Vec<Vector3<f64>>,
    /// By points, counter-clockwise as seen from outside; none in a file of points alone.
    pub faces: Vec<[usize; 3]>,
}

/// Reads a mesh file; its kind by `content_type`, or else by the file's name.
///
/// # Errors
/// What is wrong with it, with its path.
///
/// ```
/// let error = robot_mesh::read("arm.dae".as_ref(), None).unwrap_err();
/// assert!(error.starts_with("arm.dae is no STL, OBJ or MSH file"), "{error}");
/// ```
pub fn read(path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
    let shown = path.display();
    let read = reader(path, content_type)?;
    let file = File::open(path).map_err(|error| format!("cannot read {shown}: {error}"))?;
    if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Err(format!("{shown} is no ordinary file"));
    }
    let mut bytes = Vec::new();
    file.take(SIZE_LIMIT + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| format!("cannot read {shown}: {error}"))?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return Err(format!("{shown} holds more than {SIZE_LIMIT} bytes"));
    }
    checked(read(bytes), path)
}

/// The mesh in the content of a file of that path, which is not opened; its kind as [`read`] knows it.
///
/// # Errors
/// What is wrong with it, with its path.
///
/// ```
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// assert_eq!(robot_mesh::parse(text, "flag.obj".as_ref(), None)?.faces, [[0, 1, 2]]);
/// # Ok::<(), String>(())
/// ```
pub fn parse(content: &[u8], path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
    checked(reader(path, content_type)?(content.to_vec()), path)
}

/// What reads a file's bytes.
type Reader = fn(Vec<u8>) -> Result<Triangles, String>;

fn reader(path: &Path, content_type: Option<&str>) -> Result<Reader, String> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match (content_type, extension.as_str()) {
        (Some("model/stl"), _) | (None, "stl") => Ok(stl),
        (Some("model/obj"), _) | (None, "obj") => Ok(obj),
        (Some("model/vnd.mujoco.msh"), _) | (None, "msh") => Ok(msh),
        _ => Err(format!("{} is no STL, OBJ or MSH file; convert it to one of them", path.display())),
    }
}

fn checked(read: Result<Triangles, String>, path: &Path) -> Result<Triangles, String> {
    let named = |reason: String| format!("{}: {reason}", path.display());
    let triangles = read.map_err(named)?;
    check(&triangles).map_err(named)?;
    Ok(triangles)
}

/// All corners are there, and numbers.
///
/// # Errors
/// The first that is not.
///
/// ```
/// use nalgebra::Vector3;
/// let faces = vec![[0, 1, 2]];
/// let mesh = robot_mesh::Triangles { points: vec![Vector3::zeros(); 2], faces };
/// assert_eq!(robot_mesh::check(&mesh).unwrap_err(), "a triangle [0, 1, 2] of 2 points");
/// ```
pub fn check(triangles: &Triangles) -> Result<(), String> {
    let Triangles { points, faces } = triangles;
    if let Some(at) = points.iter().position(|point| point.iter().any(|x| !x.is_finite())) {
        return Err(format!("point {at} is not finite"));
    }
    if let Some(face) = faces.iter().find(|face| face.iter().any(|&corner| corner >= points.len())) {
        return Err(format!("a triangle {face:?} of {} points", points.len()));
    }
    if points.is_empty() { Err("it has no points".into()) } else { Ok(()) }
}

/// Binary or text. A binary file is known by its size, for many begin with `solid` as texts do.
fn stl(mut bytes: Vec<u8>) -> Result<Triangles, String> {
    if let Some(count) = bytes.get(80..84) {
        let count = u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
        if bytes.len() as u64 == 84 + 50 * count {
            bytes[..80].fill(0);
        }
    }
    let mut bytes = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut bytes).map_err(|error| format!("no STL: {error}"))?;
    let mut triangles = Triangles::default();
    for triangle in reader {
        let triangle = triangle.map_err(|error| format!("no STL: {error}"))?;
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
    // Materials are looks: none is read.
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| Err(tobj::LoadError::OpenFileFailed))
            .map_err(|error| format!("no OBJ: {error}"))?;
    let mut triangles = Triangles::default();
    for tobj::Model { mesh, .. } in models {
        let first = triangles.points.len();
        triangles
            .points
            .extend(mesh.positions.chunks_exact(3).map(|x| Vector3::from_fn(|k, _| f64::from(x[k]))));
        let corners: Vec<usize> = mesh.indices.iter().map(|&corner| first + corner as usize).collect();
        if corners.iter().any(|&corner| corner >= triangles.points.len()) {
            return Err("no OBJ: a face of points that are not there".into());
        }
        if mesh.face_arities.is_empty() {
            triangles.faces.extend(corners.chunks_exact(3).map(|face| [face[0], face[1], face[2]]));
            continue;
        }
        let mut rest = &corners[..];
        for arity in mesh.face_arities {
            let Some((polygon, others)) = rest.split_at_checked(arity as usize) else { break };
            rest = others;
            divide(polygon, &triangles.points, &mut triangles.faces);
        }
    }
    Ok(triangles)
}

/// Four counts of 32 bits, of points, normals, texture points and faces, then points, normals and texture points as single
/// precision numbers, then faces as indices.
#[allow(clippy::needless_pass_by_value)] // as the readers of the other kinds
fn msh(bytes: Vec<u8>) -> Result<Triangles, String> {
    let words: Vec<[u8; 4]> =
        bytes.chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]).collect();
    let header: Option<Vec<usize>> = words
        .get(..4)
        .and_then(|words| words.iter().map(|word| usize::try_from(i32::from_le_bytes(*word)).ok()).collect());
    let Some(&[points, normals, texture, faces]) = header.as_deref() else {
        return Err("no MSH: it does not begin with four counts".into());
    };
    let expected = 4 + 3 * points + 3 * normals + 2 * texture + 3 * faces;
    if expected != words.len() || !bytes.len().is_multiple_of(4) {
        return Err(format!("no MSH: {} bytes, where its counts need {}", bytes.len(), 4 * expected));
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
