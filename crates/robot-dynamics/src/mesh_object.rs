//! Objects of a scene whose shape is a mesh.

use std::path::Path;

use nalgebra::Vector3;
use robot_dynamics_mesh::{Triangles, hull, open_edges};

use crate::description::{MassProperties, ModelError, Object, Shape};

/// The mass of an object whose shape is a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshMass {
    /// None: it is fixed.
    Fixed,
    /// A uniform density \[kg/m³\].
    Density(f64),
    /// A mass \[kg\], uniformly distributed.
    Mass(f64),
    /// Mass, centre of mass and inertia in the frame of the mesh.
    Given(MassProperties),
}

/// The solid over which a mesh's mass is distributed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshSolid {
    /// The solid inside the mesh, which must be closed.
    #[default]
    Exact,
    /// The convex hull of the mesh.
    Hull,
}

/// An object whose shape is a mesh file, with factors of its coordinates along x, y, z. Its frame is that of
/// the mesh. Its shape in contact is the convex hull of the mesh.
///
/// ```
/// use robot_dynamics::{MeshMass, MeshSolid, mesh_object};
/// # let path = std::env::temp_dir().join(format!("tetrahedron_{}.obj", std::process::id()));
/// # std::fs::write(&path, "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n")?;
/// // The corner of a cube with edges of 6 cm, in a file in cm: 36 cm³.
/// let corner = mesh_object("corner", &path, [0.01; 3], MeshMass::Density(1000.0), MeshSolid::Exact)?;
/// assert!((corner.mass_properties.map_or(0.0, |body| body.mass()) - 0.036).abs() < 1e-9);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ModelError::Mesh`] if the file cannot be read, or encloses no volume; [`ModelError::Inertia`] for a mass
/// or density that is not positive and finite.
pub fn mesh_object(
    name: impl Into<String>,
    path: impl AsRef<Path>,
    scale: [f64; 3],
    mass: MeshMass,
    solid: MeshSolid,
) -> Result<Object, ModelError> {
    let path = path.as_ref();
    let mesh = robot_dynamics_mesh::read(path, None);
    let mut object = of_triangles(name, path, mesh, scale, mass, solid)?;
    if let Shape::Mesh { file, .. } = &mut object.shape {
        *file = Some(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
    }
    Ok(object)
}

/// An object of a mesh that was read, without a path to its file.
pub(crate) fn of_triangles(
    name: impl Into<String>,
    path: &Path,
    mesh: Result<Triangles, String>,
    scale: [f64; 3],
    mass: MeshMass,
    solid: MeshSolid,
) -> Result<Object, ModelError> {
    let name = name.into();
    let file = path.display().to_string();
    let refuse = |reason: String| ModelError::Mesh { file: file.clone(), reason };
    let inertia = |error| ModelError::Inertia { link: name.clone(), error };
    let mesh = mesh.map_err(refuse)?;
    if scale.iter().any(|factor| !factor.is_finite() || *factor == 0.0) {
        return Err(refuse(format!("the scale {scale:?} must be finite and not 0")));
    }
    let shape = Shape::Mesh { name: file.clone(), file: None, scale };
    let of_density = |density: f64| {
        let triangles = solid_of(&mesh, scale, solid).map_err(refuse)?;
        MassProperties::solid_mesh(density, &triangles).map_err(inertia)
    };
    let body = match mass {
        MeshMass::Fixed => return Ok(Object::fixed(name, shape)),
        MeshMass::Given(body) => body,
        MeshMass::Density(density) => of_density(density)?,
        MeshMass::Mass(mass) => {
            let unit = of_density(1.0)?;
            let moments = unit.inertia_about_center_of_mass() * (mass / unit.mass());
            MassProperties::new(mass, unit.center_of_mass(), moments).map_err(inertia)?
        }
    };
    Ok(Object::with_mass_properties(name, shape, body))
}

/// The triangles of the surface, counter-clockwise from outside.
fn solid_of(mesh: &Triangles, scale: [f64; 3], solid: MeshSolid) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    let scale = Vector3::from(scale);
    let points: Vec<Vector3<f64>> = mesh.points.iter().map(|point| point.component_mul(&scale)).collect();
    if solid == MeshSolid::Hull || mesh.faces.is_empty() {
        return hull(&points).ok_or_else(|| "all its points lie in one plane".to_owned());
    }
    let advice = "take its convex hull, or give mass, centre of mass and inertia";
    match open_edges(mesh) {
        Ok(0) => {}
        Ok(count) => return Err(format!("its surface is open at {count} edges; {advice}")),
        Err(reason) => return Err(format!("{reason}; {advice}")),
    }
    // A reflection turns the surface inside out.
    let is_reflected = scale.product() < 0.0;
    let triangle = |&[a, b, c]: &[usize; 3]| {
        let [b, c] = if is_reflected { [c, b] } else { [b, c] };
        [points[a], points[b], points[c]]
    };
    Ok(mesh.faces.iter().map(triangle).collect())
}
