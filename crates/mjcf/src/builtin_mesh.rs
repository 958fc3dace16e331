//! Meshes that the format computes from parameters: `<mesh builtin="…" params="…"/>`.
//!
//! | shape | parameters |
//! | --- | --- |
//! | `sphere` | number of subdivisions of an icosahedron, 0 to 4 |
//! | `hemisphere` | resolution, 0 to 10 |
//! | `cone` | corners of the base; radius of the top, 0 to 1 |
//! | `supersphere` | resolution; exponents of longitude and of latitude |
//! | `supertorus` | resolution; minor radius; exponents of minor and of major sections |
//! | `wedge` | resolution across and up; half angles across and up \[°\]; foveation, 0 to 1 |
//! | `plate` | resolution across and up |
//!
//! A wedge is a set of points on a sphere, without faces. A plate is a flat surface, and a shell.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use robot_dynamics_mesh::Triangles;

/// The largest resolution of shapes for which MuJoCo has no limit.
const RESOLUTION_LIMIT: f64 = 500.0;

/// The mesh of this name and these parameters.
///
/// # Errors
/// A message if the shape is not supported, or a parameter is out of range.
pub(crate) fn builtin_mesh(shape: &str, parameters: &[f64]) -> Result<Triangles, String> {
    let mesh = match (shape, parameters) {
        ("sphere", &[subdivisions]) => sphere(whole("its subdivisions", subdivisions, 0.0, 4.0)?),
        ("hemisphere", &[resolution]) => hemisphere(whole("its resolution", resolution, 0.0, 10.0)?),
        ("cone", &[corners, radius]) => {
            let corners = whole("its number of corners", corners, 3.0, RESOLUTION_LIMIT)?;
            cone(corners, within("its radius", radius, 0.0, 1.0)?)
        }
        ("supersphere", &[resolution, longitude, latitude]) => {
            let resolution = whole("its resolution", resolution, 3.0, RESOLUTION_LIMIT)?;
            let exponent = |name, value| within(name, value, 0.0, f64::MAX);
            supersphere(
                resolution,
                exponent("its first exponent", longitude)?,
                exponent("its second exponent", latitude)?,
            )
        }
        ("supertorus", &[resolution, radius, minor, major]) => {
            let resolution = whole("its resolution", resolution, 3.0, RESOLUTION_LIMIT)?;
            let positive = |name, value, most| within(name, value, f64::MIN_POSITIVE, most);
            supertorus(
                resolution,
                positive("its minor radius", radius, 1.0)?,
                positive("its first exponent", minor, f64::MAX)?,
                positive("its second exponent", major, f64::MAX)?,
            )
        }
        ("wedge", &[across, up, wide, high, foveation]) => {
            let sizes = [resolution("horizontal", across)?, resolution("vertical", up)?];
            let angle = |name, value, most| within(name, value, f64::MIN_POSITIVE, most).map(f64::to_radians);
            let angles =
                [angle("its horizontal angle", wide, 180.0)?, angle("its vertical angle", high, 90.0)?];
            wedge(sizes, angles, within("its foveation", foveation, 0.0, 1.0)?)
        }
        ("plate", &[across, up]) => plate([resolution("horizontal", across)?, resolution("vertical", up)?]),
        ("sphere" | "hemisphere", _) => return Err(format!("builtin={shape:?} has 1 number in params")),
        ("cone" | "plate", _) => return Err(format!("builtin={shape:?} has 2 numbers in params")),
        ("supersphere", _) => return Err("builtin=\"supersphere\" has 3 numbers in params".into()),
        ("supertorus", _) => return Err("builtin=\"supertorus\" has 4 numbers in params".into()),
        ("wedge", _) => return Err("builtin=\"wedge\" has 5 numbers in params".into()),
        _ => return Err(format!("builtin={shape:?} is not supported; save the mesh to a file")),
    };
    Ok(mesh)
}

/// The number of points along one side of a surface.
fn resolution(side: &str, value: f64) -> Result<usize, String> {
    whole(&format!("its {side} resolution"), value, 1.0, RESOLUTION_LIMIT)
}

fn within(name: &str, value: f64, least: f64, most: f64) -> Result<f64, String> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else if most == f64::MAX {
        let bound = if least > 0.0 { "positive" } else { "0 or more" };
        Err(format!("{name}, {value}, must be {bound}"))
    } else if least == f64::MIN_POSITIVE {
        Err(format!("{name}, {value}, must be above 0 and at most {most}"))
    } else {
        Err(format!("{name}, {value}, must be from {least} to {most}"))
    }
}

/// The integral part of a parameter, as in MuJoCo.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the limits are small and not negative
fn whole(name: &str, value: f64, least: f64, most: f64) -> Result<usize, String> {
    within(name, value.trunc(), least, most).map(|value| value as usize)
}

/// An icosahedron, each of whose triangles is divided into four, `subdivisions` times. All points lie on the
/// unit sphere.
fn sphere(subdivisions: usize) -> Triangles {
    let long = ((5.0 + 5.0_f64.sqrt()) / 10.0).sqrt();
    let short = (1.0 - long * long).sqrt();
    let mut points = Vec::new();
    for axis in 0..3 {
        for signs in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
            let mut point = Vector3::zeros();
            (point[axis], point[(axis + 1) % 3]) = (signs[0] * short, signs[1] * long);
            points.push(point);
        }
    }
    // The triangles of an icosahedron are the triples of points at the distance of an edge.
    let is_edge = |a: usize, b: usize| (points[a] - points[b]).norm() < 2.1 * short;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let is_outward = points[a].dot(&points[b].cross(&points[c])) > 0.0;
                    faces.push(if is_outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        let divide = |[a, b, c]: [usize; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    Triangles { points, faces }
}

/// The upper half of the unit sphere by rings of 4, 8, 12, … points, and its disc.
fn hemisphere(resolution: usize) -> Triangles {
    let rings = resolution + 1;
    let mut points = vec![Vector3::z()];
    for ring in 1..=rings {
        // The points of an octahedron's edges and faces with integral coordinates, moved to the sphere.
        for k in 0..4 * ring {
            let (far, near) = ((k % ring) as f64, (ring - k % ring) as f64);
            let [x, y] = [[near, far], [-far, near], [-near, -far], [far, -near]][k / ring];
            points.push(Vector3::new(x, y, (rings - ring) as f64).normalize());
        }
    }
    let center = points.len();
    points.push(Vector3::zeros());
    // Point `k` of a ring; ring 0 is the pole.
    let at = |ring: usize, k: usize| {
        if ring == 0 { 0 } else { 1 + 2 * ring * (ring - 1) + k % (4 * ring) }
    };
    let mut faces = Vec::new();
    for ring in 0..rings {
        for quarter in 0..4 {
            for j in 0..=ring {
                let (inner, outer) = (quarter * ring + j, quarter * (ring + 1) + j);
                faces.push([at(ring, inner), at(ring + 1, outer), at(ring + 1, outer + 1)]);
                if j < ring {
                    faces.push([at(ring, inner), at(ring + 1, outer + 1), at(ring, inner + 1)]);
                }
            }
        }
    }
    faces.extend((0..4 * rings).map(|k| [at(rings, k), center, at(rings, k + 1)]));
    Triangles { points, faces }
}

/// A regular polygon of radius 1 at z = −1, and one of the given radius at z = 1.
fn cone(corners: usize, radius: f64) -> Triangles {
    let ring = |radius: f64, z: f64| {
        (0..corners).map(move |k| {
            let angle = TAU * k as f64 / corners as f64;
            Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    };
    let mut points: Vec<_> = ring(1.0, -1.0).collect();
    let mut faces: Vec<_> = (1..corners - 1).map(|k| [0, k + 1, k]).collect();
    if radius == 0.0 {
        points.push(Vector3::z());
        faces.extend((0..corners).map(|k| [k, (k + 1) % corners, corners]));
    } else {
        points.extend(ring(radius, 1.0));
        faces.extend((1..corners - 1).map(|k| [corners, corners + k, corners + k + 1]));
        faces.extend(quads(corners, |k| k % corners, |k| corners + k % corners));
    }
    Triangles { points, faces }
}

/// The triangles between two rows of `count` quadrilaterals, of which `lower` and `upper` give the corners.
fn quads(
    count: usize,
    lower: impl Fn(usize) -> usize,
    upper: impl Fn(usize) -> usize,
) -> impl Iterator<Item = [usize; 3]> {
    (0..count).flat_map(move |k| {
        let [a, b, c, d] = [lower(k), lower(k + 1), upper(k), upper(k + 1)];
        [[a, b, c], [b, d, c]]
    })
}

/// sgn(x) |x|ᵉ.
fn power(x: f64, exponent: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.abs().powf(exponent).copysign(x) }
}

/// A superellipsoid of radius 1.
fn supersphere(resolution: usize, longitude: f64, latitude: f64) -> Triangles {
    let mut points = vec![-Vector3::z()];
    for ring in 1..resolution {
        let angle = PI * ring as f64 / resolution as f64;
        let (radius, z) = (power(angle.sin(), latitude), power(-angle.cos(), latitude));
        points.extend((0..resolution).map(|k| {
            let (sine, cosine) = direction(k, resolution);
            Vector3::new(-radius * power(cosine, longitude), -radius * power(sine, longitude), z)
        }));
    }
    let top = points.len();
    points.push(Vector3::z());
    let at = |ring: usize, k: usize| 1 + (ring - 1) * resolution + k % resolution;
    let mut faces: Vec<_> = (0..resolution).map(|k| [0, at(1, k + 1), at(1, k)]).collect();
    for ring in 1..resolution - 1 {
        faces.extend(quads(resolution, |k| at(ring, k), |k| at(ring + 1, k)));
    }
    faces.extend((0..resolution).map(|k| [at(resolution - 1, k), at(resolution - 1, k + 1), top]));
    Triangles { points, faces }
}

/// Sine and cosine of 2πk/n, exactly zero where the exact value is zero.
fn direction(k: usize, n: usize) -> (f64, f64) {
    let (sine, cosine) = (TAU * k as f64 / n as f64).sin_cos();
    let is_multiple_of =
        |parts: usize, odd: bool| (parts * k).is_multiple_of(n) && (!odd || (parts * k / n) % 2 == 1);
    (if is_multiple_of(2, false) { 0.0 } else { sine }, if is_multiple_of(4, true) { 0.0 } else { cosine })
}

/// A supertoroid of major radius 1.
fn supertorus(resolution: usize, radius: f64, minor: f64, major: f64) -> Triangles {
    let mut points = Vec::new();
    for u in 0..resolution {
        let (sine, cosine) = direction(u, resolution);
        for v in 0..resolution {
            let (height, across) = direction(v, resolution);
            let distance = 1.0 + radius * power(across, minor);
            points.push(Vector3::new(
                distance * power(cosine, major),
                distance * power(sine, major),
                radius * power(height, minor),
            ));
        }
    }
    let at = |u: usize, v: usize| u % resolution * resolution + v % resolution;
    let mut faces = Vec::new();
    for v in 0..resolution {
        faces.extend(quads(resolution, |u| at(u, v), |u| at(u, v + 1)));
    }
    Triangles { points, faces }
}

/// Points on the unit sphere about −z, at the centres of a grid of azimuths and elevations. The grid extends
/// by the given angles to both sides. With foveation it is finer in the middle.
fn wedge(sizes: [usize; 2], angles: [f64; 2], foveation: f64) -> Triangles {
    let edge = |axis: usize, k: usize| {
        let x = 2.0 * k as f64 / sizes[axis] as f64 - 1.0;
        angles[axis] * (foveation * x.powi(5) + (1.0 - foveation) * x)
    };
    let center = |axis: usize, k: usize| 0.5 * (edge(axis, k) + edge(axis, k + 1));
    let mut points = Vec::with_capacity(sizes[0] * sizes[1]);
    for i in 0..sizes[0] {
        let (sine, cosine) = center(0, i).sin_cos();
        points.extend((0..sizes[1]).map(|j| {
            let (height, radius) = center(1, j).sin_cos();
            Vector3::new(radius * sine, height, -radius * cosine)
        }));
    }
    Triangles { points, faces: Vec::new() }
}

/// The centres of the cells of a grid on the square of side 2 at z = −1, joined by triangles.
fn plate(sizes: [usize; 2]) -> Triangles {
    let center = |axis: usize, k: usize| (2 * k + 1) as f64 / sizes[axis] as f64 - 1.0;
    let mut points = Vec::with_capacity(sizes[0] * sizes[1]);
    for i in 0..sizes[0] {
        points.extend((0..sizes[1]).map(|j| Vector3::new(center(0, i), center(1, j), -1.0)));
    }
    let at = |i: usize, j: usize| i * sizes[1] + j;
    let mut faces = Vec::new();
    for j in 1..sizes[1] {
        faces.extend(quads(sizes[0] - 1, |i| at(i, j - 1), |i| at(i, j)));
    }
    Triangles { points, faces }
}
