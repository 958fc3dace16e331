//! Velocities and forces along the axes of a contact.

use nalgebra::Vector3;
use robot_dynamics_description::Surface;

use super::MOST_ROWS;
use crate::contact::shape_checks::rows_of;
use crate::contact::shape_point::ShapePoint;

/// Force and moment in world axes.
pub(super) fn in_world(point: &ShapePoint, force: &[f64; MOST_ROWS]) -> (Vector3<f64>, Vector3<f64>) {
    let [n, s, t] = &point.axes;
    let at = |k: usize| n * force[k] + s * force[k + 1] + t * force[k + 2];
    (at(0), at(3))
}

/// Normal and tangential components of a velocity, then those of an angular velocity.
pub(super) fn along_axes(
    point: &ShapePoint,
    velocity: &Vector3<f64>,
    spin: &Vector3<f64>,
) -> [f64; MOST_ROWS] {
    let [n, s, t] = &point.axes;
    [n.dot(velocity), s.dot(velocity), t.dot(velocity), n.dot(spin), s.dot(spin), t.dot(spin)]
}

/// The number of rows of a contact, and their factors. Moments are scaled by the ratio of sliding friction to
/// theirs, so that the cone is round.
pub(super) fn directions(surface: &Surface, friction: f64) -> (usize, [f64; MOST_ROWS]) {
    let [_, torsion, rolling] = surface.friction;
    let mut scale = [1.0; MOST_ROWS];
    if friction <= 0.0 {
        return (1, scale);
    }
    let [torsion, rolling] = [torsion, rolling].map(|moment| moment.max(0.0) / friction);
    (scale[3], scale[4], scale[5]) = (torsion, rolling, rolling);
    // Rows with zero friction moment are left out at the end. Torsion with zero friction stays before
    // rolling, with the factor 0.
    let rows = match rows_of(surface.condim) {
        6 if rolling > 0.0 => 6,
        4 | 6 if torsion > 0.0 => 4,
        1 => 1,
        _ => 3,
    };
    (rows, scale)
}
