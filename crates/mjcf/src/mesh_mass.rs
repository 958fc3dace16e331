//! What a mesh's mass is, by each of the format's four ways.

use dynamics::MassProperties;
use nalgebra::{Matrix3, Vector3};

use robot_mesh::{Triangles, hull};

/// The format's words for how a mesh holds mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshInertia {
    /// The solid that it bounds.
    Exact,
    /// Its convex hull.
    Convex,
    /// Its surface.
    Shell,
    /// The pyramids from its middle to each triangle, all counted as positive: right for a convex mesh, too much for
    /// others, and the format's default.
    Legacy,
}

/// A mesh filled evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshExtent {
    /// Volume \[m³\], or of a shell area \[m²\].
    pub(crate) measure: f64,
    /// At density 1, in the mesh's frame.
    pub(crate) body: MassProperties,
}

/// Mass of a mesh at density 1; a mesh of points alone is its hull.
pub(crate) fn extent(mesh: &Triangles, inertia: MeshInertia) -> Result<MeshExtent, String> {
    let convex;
    let triangles: Vec<[Vector3<f64>; 3]> = if mesh.faces.is_empty() || inertia == MeshInertia::Convex {
        convex = hull(&mesh.points).ok_or("all its points lie in one plane")?;
        convex
    } else {
        mesh.faces.iter().map(|face| face.map(|corner| mesh.points[corner])).collect()
    };
    let body = match inertia {
        MeshInertia::Exact | MeshInertia::Convex => MassProperties::solid_mesh(1.0, &triangles)
            .map_err(|error| format!("{error}: are its triangles counter-clockwise as seen from outside?")),
        MeshInertia::Shell => MassProperties::shell_mesh(1.0, &triangles).map_err(|error| error.to_string()),
        MeshInertia::Legacy => {
            legacy(&triangles).ok_or_else(|| "it has no volume; give it inertia=\"shell\"".to_owned())
        }
    }?;
    Ok(MeshExtent { measure: body.mass(), body })
}

/// The volumes from the middle of the surface give the centre of mass; those from there the mass and inertia.
fn legacy(triangles: &[[Vector3<f64>; 3]]) -> Option<MassProperties> {
    let surface = MassProperties::shell_mesh(1.0, triangles).ok()?;
    let middle = surface.center_of_mass();
    let volume = |[p, q, r]: &[Vector3<f64>; 3]| (p.dot(&q.cross(r)) / 6.0).abs();
    let (mut total, mut first) = (0.0, Vector3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - middle);
        let part = volume(&corners);
        total += part;
        first += corners.iter().sum::<Vector3<f64>>() * (0.25 * part);
    }
    let center = middle + first / total;
    let (mut total, mut second) = (0.0, Matrix3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - center);
        let part = volume(&corners);
        let s = corners.iter().sum::<Vector3<f64>>();
        let squares = corners.iter().fold(s * s.transpose(), |sum, x| sum + x * x.transpose());
        total += part;
        second += squares * (part / 20.0);
    }
    let inertia = Matrix3::from_diagonal_element(second.trace()) - second;
    MassProperties::as_written(total, center, inertia).ok().filter(|body| body.mass() > 1e-15)
}
