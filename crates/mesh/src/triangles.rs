//! Triangle meshes.

use nalgebra::Vector3;

/// A mesh as in its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Points, in the units of the file.
    pub points: Vec<Vector3<f64>>,
    /// Triangles as indices of points, counter-clockwise from outside; empty for a file of points.
    pub faces: Vec<[usize; 3]>,
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

/// The point of a text file with these words: three numbers in single precision.
pub(crate) fn point_of<'a>(words: impl Iterator<Item = &'a [u8]>) -> Option<Vector3<f64>> {
    let number = |word: &[u8]| core::str::from_utf8(word).ok()?.parse::<f32>().ok();
    let numbers: Option<Vec<f64>> = words.map(|word| number(word).map(f64::from)).collect();
    let [x, y, z] = numbers?.try_into().ok()?;
    Some(Vector3::new(x, y, z))
}
