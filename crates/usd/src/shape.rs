//! Reads shapes: boxes, balls, cylinders, capsules, planes and meshes, with their scale.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{Pose, Shape, z_onto};

use crate::geometry::Geometry;
use crate::prim::Prim;
use crate::transform::matrix;
use crate::value;

/// Two scales are equal if they differ by this part. Scales are floats.
const EQUAL: f64 = 1e-6;

/// The corners of a mesh's triangles, in the frame of the node.
pub(crate) type Triangles = Vec<[Vector3<f64>; 3]>;

/// The names of the types of shapes.
pub(crate) const SHAPES: [&str; 11] = [
    "Cube",
    "Sphere",
    "Cylinder",
    "Cylinder_1",
    "Capsule",
    "Capsule_1",
    "Plane",
    "Mesh",
    "Cone",
    "Points",
    "TetMesh",
];

/// A shape with its pose in the node.
#[derive(Clone, Debug)]
pub(crate) struct PlacedShape {
    pub(crate) pose: Pose,
    pub(crate) shape: Shape,
    /// The triangles of a mesh; none for other shapes.
    pub(crate) triangles: Triangles,
}

/// The shape of a prim; `None` for a prim of another type.
pub(crate) fn read_shape(geometry: &Geometry<'_>, at: usize) -> Result<Option<PlacedShape>, String> {
    let prim = &geometry.scene.prims[at];
    if !SHAPES.contains(&prim.type_name.as_str()) {
        return Ok(None);
    }
    let transform = geometry.node_from_prim(at);
    let mut pose = transform.rigid();
    let stretch = transform.stretch();
    let scale = stretch.diagonal().abs();
    let is_sheared = (stretch - Matrix3::from_diagonal(&stretch.diagonal())).amax() > EQUAL * scale.amax();
    if is_sheared && prim.type_name != "Mesh" {
        return Err("its scale is not along its axes; apply it to a mesh".to_owned());
    }
    let length = |name: &str, default: f64| -> Result<f64, String> {
        let value = prim.number(name).unwrap_or(default);
        let is_valid = value >= 0.0 && value.is_finite();
        if is_valid { Ok(value) } else { Err(format!("{name} = {value} is not a length; correct it")) }
    };
    let shape = match prim.type_name.as_str() {
        "Cube" => Shape::Box { size: (scale * length("size", 2.0)?).into() },
        "Sphere" => {
            let half_axes = scale * length("radius", 1.0)?;
            if is_equal(half_axes[0], half_axes[1]) && is_equal(half_axes[1], half_axes[2]) {
                Shape::Sphere { radius: half_axes[0] }
            } else {
                Shape::Ellipsoid { half_axes: half_axes.into() }
            }
        }
        "Cylinder" | "Cylinder_1" | "Capsule" | "Capsule_1" => {
            let is_capsule = prim.type_name.starts_with("Capsule");
            let (radius, height) = if is_capsule { (0.5, 1.0) } else { (1.0, 2.0) };
            let radius = match (prim.number("radiusTop"), prim.number("radiusBottom")) {
                (Some(top), Some(bottom)) if top == bottom => top,
                (None, None) => length("radius", radius)?,
                _ => return Err("its two radii differ; make it a mesh".to_owned()),
            };
            let axis = axis(prim)?;
            let across = [scale[(axis + 1) % 3], scale[(axis + 2) % 3]];
            if !is_equal(across[0], across[1]) {
                return Err("its scale differs across its axis; make it a mesh".to_owned());
            }
            pose = pose.compose(&z_onto(Vector3::ith(axis, 1.0).into()));
            let (radius, length) = (radius * across[0], length("height", height)? * scale[axis]);
            if is_capsule { Shape::Capsule { radius, length } } else { Shape::Cylinder { radius, length } }
        }
        "Plane" => {
            pose = pose.compose(&z_onto(Vector3::ith(axis(prim)?, 1.0).into()));
            Shape::Plane { half_size: [0.0; 2] }
        }
        "Mesh" => {
            let triangles = triangles(prim)?;
            let triangles =
                triangles.iter().map(|corners| corners.map(|corner| transform.apply(corner))).collect();
            let is_mirrored = transform.linear.determinant() < 0.0;
            let triangles = if is_mirrored { mirrored(triangles) } else { triangles };
            return Ok(Some(PlacedShape { pose, shape: mesh(prim, scale), triangles }));
        }
        other => return Err(format!("shapes of type {other} are not read; make it a mesh")),
    };
    Ok(Some(PlacedShape { pose, shape, triangles: Vec::new() }))
}

fn mesh(prim: &Prim, scale: Vector3<f64>) -> Shape {
    Shape::Mesh { name: prim.path.clone(), file: None, scale: scale.into() }
}

fn mirrored(triangles: Triangles) -> Triangles {
    triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

fn is_equal(a: f64, b: f64) -> bool {
    (a - b).abs() <= EQUAL * a.abs().max(b.abs())
}

/// The axis of a shape, Z by default.
fn axis(prim: &Prim) -> Result<usize, String> {
    match prim.word("axis") {
        None | Some("Z") => Ok(2),
        Some("X") => Ok(0),
        Some("Y") => Ok(1),
        Some(other) => Err(format!("axis = {other:?} is unknown; use X, Y or Z")),
    }
}

/// The triangles of a mesh in its own frame, counter-clockwise seen from outside. Faces are fans.
fn triangles(prim: &Prim) -> Result<Triangles, String> {
    let points = prim.numbers("points").unwrap_or_default();
    let points: Vec<Vector3<f64>> = points.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let indices = prim.numbers("faceVertexIndices").unwrap_or_default();
    let counts = prim.numbers("faceVertexCounts").unwrap_or_default();
    let is_left_handed = prim.word("orientation") == Some("leftHanded");
    let mut found = Vec::new();
    let mut start = 0_usize;
    for &corners in counts {
        let count = value::count(corners).unwrap_or_default();
        let Some(face) = start.checked_add(count).and_then(|end| indices.get(start..end)) else {
            return Err("faceVertexIndices has too few numbers for faceVertexCounts; export the mesh again"
                .to_owned());
        };
        let corner = |at: usize| -> Result<Vector3<f64>, String> {
            let index = face[at];
            let point = value::count(index).and_then(|index| points.get(index));
            let reason = || {
                format!("a face names point {index}, and there are {}; export the mesh again", points.len())
            };
            point.copied().ok_or_else(reason)
        };
        for at in 2..count {
            let [a, b, c] = [corner(0)?, corner(at - 1)?, corner(at)?];
            found.push(if is_left_handed { [a, c, b] } else { [a, b, c] });
        }
        start += count;
    }
    Ok(found)
}

/// The rotation of a pose.
pub(crate) fn rotation(pose: &Pose) -> nalgebra::Rotation3<f64> {
    nalgebra::Rotation3::from_matrix_unchecked(matrix(pose))
}
