//! The parallel-axis theorem, in the plane and in space.

use nalgebra::{Matrix3, Vector3};

/// I = I_c + m d²: the moment about an axis at distance `distance` from the centre of mass. **(PRM 10.33)**
///
/// Units are kg·m², kg and m.
///
/// ```
/// // A rod of 1 m and 3 kg about its end: m l²/12 + m (l/2)² = m l²/3.
/// assert!((robot_dynamics::description::parallel_axis_planar(3.0 / 12.0, 3.0, 0.5) - 1.0).abs() < 1e-15);
/// ```
pub fn parallel_axis_planar(moment_about_center_of_mass: f64, mass: f64, distance: f64) -> f64 {
    moment_about_center_of_mass + mass * distance * distance
}

/// 𝓘 = 𝓘_c + m(|r|²1 − r rᵀ): the inertia about a point at the offset r from the centre of mass (or −r, which
/// gives the same). Axes stay parallel. **(PRM 10.46)**
///
/// ```
/// use nalgebra::{Matrix3, Vector3};
/// use robot_dynamics::description::parallel_axis;
/// // A thin rod of 3 kg along x, 1 m long: m l²/12 about its middle, m l²/3 about its end.
/// let about_middle = Matrix3::from_diagonal(&Vector3::new(0.0, 0.25, 0.25));
/// let about_end = parallel_axis(&about_middle, 3.0, &Vector3::new(0.5, 0.0, 0.0));
/// assert!((about_end - Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0))).norm() < 1e-15);
/// ```
pub fn parallel_axis(
    inertia_about_center_of_mass: &Matrix3<f64>,
    mass: f64,
    offset: &Vector3<f64>,
) -> Matrix3<f64> {
    inertia_about_center_of_mass + point_inertia(mass, offset)
}

/// m(|r|²1 − r rᵀ): the inertia of a point of mass m at r, about the origin. **(PRM 10.42)**
pub(super) fn point_inertia(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    let (x, y, z) = (r.x, r.y, r.z);
    // Written out, y² + z² has no cancellation, unlike |r|² − x².
    Matrix3::new(y * y + z * z, -x * y, -x * z, -x * y, x * x + z * z, -y * z, -x * z, -y * z, x * x + y * y)
        * mass
}
