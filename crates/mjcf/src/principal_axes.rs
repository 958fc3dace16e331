//! The principal axes that MuJoCo chooses for an inertia.
//!
//! The force of a fluid on an inertia box depends on its axes even if two moments are equal. The axes of such
//! an inertia are those that Jacobi's method finds in MuJoCo's order of pivots.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Off-diagonal entries below this are taken as zero \[kg·m²\].
const NEGLIGIBLE: f64 = 1e-12;

/// The principal axes as columns, by rotations that each remove the largest off-diagonal entry, with the
/// larger moments first.
pub(crate) fn principal_axes(inertia: &Matrix3<f64>) -> Rotation3<f64> {
    let mut turn = UnitQuaternion::identity();
    let along = |turn: &UnitQuaternion<f64>| {
        let axes = turn.to_rotation_matrix();
        axes.matrix().transpose() * inertia * axes.matrix()
    };
    let mut moments = along(&turn);
    for _ in 0..500 {
        let sizes = [moments[(0, 1)], moments[(0, 2)], moments[(1, 2)]].map(f64::abs);
        let (row, column, axis) = if sizes[0] > sizes[1] && sizes[0] > sizes[2] {
            (0, 1, 2)
        } else if sizes[1] > sizes[2] {
            (0, 2, 1)
        } else {
            (1, 2, 0)
        };
        let entry = moments[(row, column)];
        // A NaN ends the iteration, too.
        if entry.abs() < NEGLIGIBLE || !entry.is_finite() {
            break;
        }
        // The tangent of the angle, at most 1.
        let ratio = (moments[(column, column)] - moments[(row, row)]) / (2.0 * entry);
        let tangent = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
        let sign = if axis == 1 { 1.0 } else { -1.0 };
        turn *= about(axis, sign * tangent.atan());
        turn.renormalize();
        moments = along(&turn);
    }
    let mut values = moments.diagonal();
    for first in [0, 1, 0] {
        if values[first] + NEGLIGIBLE < values[first + 1] {
            values.swap_rows(first, first + 1);
            turn *= about((first + 2) % 3, core::f64::consts::FRAC_PI_2);
        }
    }
    turn.to_rotation_matrix()
}

/// A rotation about a coordinate axis.
fn about(axis: usize, angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new(Vector3::ith(axis, angle))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};

    use super::principal_axes;

    /// Random rotations of given moments are undone, with the moments in descending order.
    #[test]
    fn the_axes_diagonalize_the_inertia() {
        for seed in 0..50 {
            let x = f64::from(seed);
            let turn = Rotation3::new(Vector3::new((x * 1.7).sin(), (x * 2.3).cos(), (x * 0.9).sin()) * 3.0);
            let moments = [3.0, 2.0, if seed % 2 == 0 { 2.0 } else { 1.5 }];
            let inertia = turn * Matrix3::from_diagonal(&Vector3::from(moments)) * turn.transpose();
            let axes = principal_axes(&inertia);
            let found = axes.transpose() * inertia * axes;
            let error = (found - Matrix3::from_diagonal(&Vector3::from(moments))).abs().max();
            assert!(error < 1e-11, "{seed}: {found}");
        }
    }
}
