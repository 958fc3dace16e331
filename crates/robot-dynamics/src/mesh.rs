//! The points of a shape's mesh file.

use multibody::{LinkShape, Shape};

/// The corners of the convex hull of a mesh, in the shape's frame \[m\]: what `ContactSet::with_meshes` asks for.
///
/// ```
/// use robot_dynamics::{LinkShape, Pose, Shape, ShapeRole, mesh_corners};
/// let shape = LinkShape::new("arm", ShapeRole::Collision, Pose::IDENTITY, Shape::mesh("arm.stl"));
/// assert_eq!(mesh_corners(&shape).unwrap_err(), "its file was not found");
/// ```
///
/// # Errors
/// The shape is no mesh, its file was not found, or what is wrong with it.
pub fn mesh_corners(shape: &LinkShape) -> Result<Vec<[f64; 3]>, String> {
    let Shape::Mesh { file, scale, .. } = &shape.shape else { return Err("it is no mesh".into()) };
    let path = file.as_deref().ok_or("its file was not found")?;
    let corners = robot_mesh::corners(&robot_mesh::read(path, None)?.points);
    Ok(corners.iter().map(|corner| core::array::from_fn(|k| scale[k] * corner[k])).collect())
}
