//! Inertia of bodies bounded by triangles: exact integrals over the polyhedron, or over its surface.
//!
//! The triangle (a, b, c) and a point o span a tetrahedron of the signed volume V = (a−o)·((b−o)×(c−o))/6. V
//! is positive if the triangle is counter-clockwise seen from outside. The sum over a closed surface is the
//! solid's, for any o. With p, q, r from o to the corners and s = p + q + r,
//!
//! - ∫ x dV = V s/4 and ∫ x xᵀ dV = V (s sᵀ + p pᵀ + q qᵀ + r rᵀ)/20 over the tetrahedron,
//! - ∫ x dA = A s/3 and ∫ x xᵀ dA = A (s sᵀ + p pᵀ + q qᵀ + r rᵀ)/12 over the triangle of area A.
//!
//! The integrals of polynomials over simplices are exact for every mesh. 𝓘 = (tr ∫xxᵀ) 1 − ∫xxᵀ. **(PRM
//! 10.42)**

use nalgebra::{Matrix3, Vector3};

use super::error::{finite, positive};
use super::{InertiaError, MassProperties};

impl MassProperties {
    /// The solid of density ρ \[kg/m³\] inside a closed mesh. Each triangle is counter-clockwise seen from
    /// outside.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use robot_dynamics::description::MassProperties;
    /// // The corner of a unit cube: volume 1/6, its centre at a quarter of each edge.
    /// let (o, x, y, z) = (Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z());
    /// let corner = MassProperties::solid_mesh(6.0, &[[o, y, x], [o, z, y], [o, x, z], [x, y, z]])?;
    /// assert!((corner.mass() - 1.0).abs() < 1e-15);
    /// assert!((corner.center_of_mass() - Vector3::repeat(0.25)).amax() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if a coordinate is not finite, the density is not positive, or the volume is not
    /// positive, as for a mesh with clockwise triangles.
    pub fn solid_mesh(density: f64, triangles: &[[Vector3<f64>; 3]]) -> Result<Self, InertiaError> {
        sum(density, triangles, "volume", |[p, q, r]| (p.dot(&q.cross(r)) / 6.0, 4.0, 20.0))
    }

    /// The surface of a mesh, closed or not, of density ρ \[kg/m²\].
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use robot_dynamics::description::MassProperties;
    /// let plate = [Vector3::zeros(), Vector3::x(), Vector3::y()];
    /// let plate = MassProperties::shell_mesh(2.0, &[plate])?;
    /// assert!((plate.mass() - 1.0).abs() < 1e-15 && (plate.center_of_mass().x - 1.0 / 3.0).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    ///
    /// # Errors
    /// [`InertiaError`] if a coordinate is not finite, or the density or the area is not positive.
    pub fn shell_mesh(density: f64, triangles: &[[Vector3<f64>; 3]]) -> Result<Self, InertiaError> {
        sum(density, triangles, "area", |[p, q, r]| (0.5 * (q - p).cross(&(r - p)).norm(), 3.0, 12.0))
    }
}

/// The sum over all triangles, first about their mean, then about the centre of mass, to avoid cancellation.
/// `measure` gives a piece's volume or area and the two denominators.
fn sum(
    density: f64,
    triangles: &[[Vector3<f64>; 3]],
    quantity: &'static str,
    measure: impl Fn(&[Vector3<f64>; 3]) -> (f64, f64, f64),
) -> Result<MassProperties, InertiaError> {
    positive("density", density)?;
    for corner in triangles.iter().flatten() {
        finite("mesh", corner.as_slice())?;
    }
    let corners = 3.0 * triangles.len().max(1) as f64;
    let middle = triangles.iter().flatten().sum::<Vector3<f64>>() / corners;
    let (mut total, mut first) = (0.0, Vector3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - middle);
        let (part, thirds, _) = measure(&corners);
        total += part;
        first += corners.iter().sum::<Vector3<f64>>() * (part / thirds);
    }
    positive(quantity, total)?;
    let center = middle + first / total;
    let mut second = Matrix3::zeros();
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - center);
        let (part, _, divisor) = measure(&corners);
        let s = corners.iter().sum::<Vector3<f64>>();
        let squares = corners.iter().fold(s * s.transpose(), |sum, x| sum + x * x.transpose());
        second += squares * (part / divisor);
    }
    let inertia = Matrix3::from_diagonal_element(second.trace()) - second;
    MassProperties::as_written(density * total, center, inertia * density)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    type Triangles = Vec<[Vector3<f64>; 3]>;

    /// A box about the origin, two triangles to a face.
    fn brick(edges: Vector3<f64>) -> Triangles {
        let mut triangles = Triangles::new();
        for axis in 0..3 {
            for side in [-0.5, 0.5] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |a: f64, b: f64| {
                    let mut x = Vector3::zeros();
                    (x[axis], x[u], x[v]) = (side * edges[axis], a * edges[u], b * edges[v]);
                    x
                };
                let [a, b, c, d] =
                    [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
                let faces = if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                triangles.extend(faces);
            }
        }
        triangles
    }

    /// Splits each triangle into four, with the new corners on the unit sphere.
    fn refined(triangles: &Triangles) -> Triangles {
        let on_sphere = |a: Vector3<f64>, b: Vector3<f64>| (a + b).normalize();
        triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (on_sphere(a, b), on_sphere(b, c), on_sphere(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect()
    }

    #[test]
    fn a_box_of_triangles_is_the_box() {
        let edges = Vector3::new(0.3, 0.2, 0.1);
        let (mesh, exact) =
            (MassProperties::solid_mesh(1000.0, &brick(edges)), MassProperties::solid_box(1000.0, edges));
        let (mesh, exact) = (mesh.expect("a body"), exact.expect("a body"));
        assert!((mesh.mass() - exact.mass()).abs() < 1e-14, "{mesh:?}");
        assert!(mesh.center_of_mass().amax() < 1e-16, "{mesh:?}");
        let off = mesh.inertia_about_center_of_mass() - exact.inertia_about_center_of_mass();
        assert!(off.amax() < 1e-16, "{off}");
    }

    #[test]
    fn a_mesh_far_away_and_turned_is_the_body_there() {
        let edges = Vector3::new(0.3, 0.2, 0.1);
        let (turn, shift) = (Rotation3::from_euler_angles(0.3, -1.1, 2.0), Vector3::new(100.0, -50.0, 20.0));
        let moved: Triangles =
            brick(edges).iter().map(|triangle| triangle.map(|corner| turn * corner + shift)).collect();
        let mesh = MassProperties::solid_mesh(1000.0, &moved).expect("a body");
        let exact = MassProperties::solid_box(1000.0, edges).expect("a body").transformed(&turn, &shift);
        // The corners are rounded to 1e-14 m, 1e-13 of the box.
        let off = mesh.inertia_about_center_of_mass() - exact.inertia_about_center_of_mass();
        assert!(off.amax() < 1e-12 * exact.inertia_about_center_of_mass().amax(), "{off}");
        assert!((mesh.center_of_mass() - exact.center_of_mass()).amax() < 1e-13);
    }

    /// Inscribed polyhedra deviate from the ball, and from its surface, by a term in h², so each refinement
    /// divides the error by 4.
    #[test]
    fn refined_meshes_converge_to_the_ball_and_its_shell() {
        let mut mesh: Triangles = brick(Vector3::repeat(1.0))
            .iter()
            .map(|triangle| triangle.map(|corner| corner.normalize()))
            .collect();
        let mut errors = Vec::new();
        for _ in 0..6 {
            mesh = refined(&mesh);
            let ball = MassProperties::solid_mesh(1.0, &mesh).expect("a body");
            let shell = MassProperties::shell_mesh(1.0, &mesh).expect("a body");
            let volume = 4.0 / 3.0 * core::f64::consts::PI;
            // 2/5 m r² and 2/3 m r² of the exact masses.
            let ball_off =
                (ball.inertia_about_center_of_mass() - Matrix3::identity() * (0.4 * volume)).amax();
            let shell_off =
                (shell.inertia_about_center_of_mass() - Matrix3::identity() * (2.0 * volume)).amax();
            errors.push([ball_off, shell_off]);
        }
        for pair in errors.windows(2).skip(2) {
            for kind in 0..2 {
                let ratio = pair[0][kind] / pair[1][kind];
                assert!((3.8..4.2).contains(&ratio), "{errors:?}");
            }
        }
        assert!(errors[5][0] < 1e-3 && errors[5][1] < 1e-2, "{errors:?}");
    }

    /// Six plates of a cube of edge a: 𝓘 = 5/18 m a² about each axis.
    #[test]
    fn a_hollow_cube() {
        let shell = MassProperties::shell_mesh(3.0, &brick(Vector3::repeat(0.2))).expect("a body");
        let expected = Matrix3::identity() * (5.0 / 18.0 * shell.mass() * 0.04);
        assert!((shell.mass() - 3.0 * 6.0 * 0.04).abs() < 1e-15);
        assert!((shell.inertia_about_center_of_mass() - expected).amax() < 1e-16);
    }

    #[test]
    fn what_is_no_body_is_refused() {
        let inside_out: Triangles = brick(Vector3::repeat(1.0)).iter().map(|&[a, b, c]| [a, c, b]).collect();
        let refused = MassProperties::solid_mesh(1.0, &inside_out).expect_err("a negative volume");
        assert_eq!(refused.to_string(), "the volume is -1; it must be positive");
        let flat = [[Vector3::zeros(), Vector3::x(), Vector3::x()]];
        assert!(MassProperties::shell_mesh(1.0, &flat).is_err());
        assert!(MassProperties::solid_mesh(1.0, &[]).is_err());
        let broken = [[Vector3::zeros(), Vector3::x(), Vector3::repeat(f64::NAN)]];
        assert!(matches!(MassProperties::solid_mesh(1.0, &broken), Err(InertiaError::Input(_))));
    }
}
