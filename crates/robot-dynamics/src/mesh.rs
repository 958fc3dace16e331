//! Reads the mesh file of a shape.

use crate::description::{LinkShape, Shape};

/// The corners of the convex hull of a mesh, in the frame of the shape \[m\], for `ContactSet::with_meshes`.
///
/// ```
/// use robot_dynamics::mesh_corners;
/// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole};
/// let shape = LinkShape::new("arm", ShapeRole::Collision, Pose::IDENTITY, Shape::mesh("arm.stl"));
/// assert_eq!(mesh_corners(&shape).unwrap_err(), "its file was not found");
/// ```
///
/// # Errors
/// A message if the shape is not a mesh, or if its file was not found or is invalid.
pub fn mesh_corners(shape: &LinkShape) -> Result<Vec<[f64; 3]>, String> {
    let Shape::Mesh { file, scale, .. } = &shape.shape else { return Err("it is not a mesh".into()) };
    let path = file.as_deref().ok_or("its file was not found")?;
    let corners = robot_dynamics_mesh::corners(&robot_dynamics_mesh::read(path, None)?.points);
    Ok(corners.iter().map(|corner| core::array::from_fn(|k| scale[k] * corner[k])).collect())
}
