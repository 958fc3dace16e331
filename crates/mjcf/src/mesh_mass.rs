//! The mass properties of a mesh, by the four methods of MJCF.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use robot_dynamics_description::MassProperties;
use robot_dynamics_mesh::{Triangles, hull, open_edges};

use crate::principal_axes::principal_axes;

/// The values of the attribute `inertia` of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshInertia {
    /// The solid inside the mesh.
    Exact,
    /// The convex hull.
    Convex,
    /// The surface.
    Shell,
    /// The pyramids from the centre to each triangle, all with positive volume. This is exact for a convex
    /// mesh and overestimates others. It is the default of MJCF.
    Legacy,
}

/// A mesh of uniform density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshExtent {
    /// Volume \[m³\], or area \[m²\] of a shell.
    pub(crate) measure: f64,
    /// At density 1, in the mesh's frame.
    pub(crate) body: MassProperties,
    /// The number of edges where the surface of a solid is open.
    pub(crate) open_edges: usize,
    /// The frame at the centre of mass along the principal axes, and the largest distance of the mesh's
    /// points from each of its coordinate planes.
    pub(crate) mesh_from_box: Isometry3<f64>,
    pub(crate) half_size: [f64; 3],
    /// The middle of the bounding box of the points along these axes, and half its size.
    pub(crate) bounds: [[f64; 3]; 2],
}

/// The mass properties of a mesh at density 1. For a mesh without faces they are those of its convex hull.
pub(crate) fn extent(mesh: &Triangles, inertia: MeshInertia) -> Result<MeshExtent, String> {
    let convex;
    let triangles: Vec<[Vector3<f64>; 3]> = if mesh.faces.is_empty() || inertia == MeshInertia::Convex {
        convex = hull(&mesh.points).ok_or("all its points lie in one plane")?;
        convex
    } else {
        mesh.faces.iter().map(|face| face.map(|corner| mesh.points[corner])).collect()
    };
    let mut open = 0;
    let body = match inertia {
        MeshInertia::Exact if !mesh.faces.is_empty() => {
            open = open_edges(mesh)?;
            sum_of_pyramids(&triangles, |volume| volume).ok_or_else(|| {
                "its volume is not positive; check that its triangles are counter-clockwise from outside"
                    .into()
            })
        }
        MeshInertia::Exact | MeshInertia::Convex => {
            MassProperties::solid_mesh(1.0, &triangles).map_err(|error| error.to_string())
        }
        MeshInertia::Shell => MassProperties::shell_mesh(1.0, &triangles).map_err(|error| error.to_string()),
        MeshInertia::Legacy => sum_of_pyramids(&triangles, f64::abs)
            .ok_or_else(|| "it has no volume; give it inertia=\"shell\"".to_owned()),
    }?;
    let axes = principal_axes(&body.inertia_about_center_of_mass());
    let mesh_from_box = Isometry3::from_parts(Translation3::from(body.center_of_mass()), axes.into());
    let points = mesh.points.iter().map(|point| axes.inverse() * (point - body.center_of_mass()));
    let infinite = Vector3::from_element(f64::INFINITY);
    let [least, most] = points.fold([infinite, -infinite], |[a, b], x| [a.inf(&x), b.sup(&x)]);
    let half_size = least.abs().sup(&most.abs()).into();
    let bounds = [(least + most) * 0.5, (most - least) * 0.5].map(<[f64; 3]>::from);
    Ok(MeshExtent { measure: body.mass(), body, open_edges: open, mesh_from_box, half_size, bounds })
}

/// The pyramids from the centroid of the surface give the centre of mass. Those from the centre of mass give
/// mass and inertia. `counted` maps the signed volume of a pyramid to the counted one. For a closed surface
/// the signed volumes are exact, from any point. For an open one these two points are MuJoCo's.
fn sum_of_pyramids(triangles: &[[Vector3<f64>; 3]], counted: fn(f64) -> f64) -> Option<MassProperties> {
    let surface = MassProperties::shell_mesh(1.0, triangles).ok()?;
    let middle = surface.center_of_mass();
    let volume = |[p, q, r]: &[Vector3<f64>; 3]| counted(p.dot(&q.cross(r)) / 6.0);
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
