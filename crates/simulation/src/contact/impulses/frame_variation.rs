//! The derivative of a contact's point and axes by the relative motion of its two bodies.

use nalgebra::Vector3;
use robot_dynamics_core::model::WORLD;

use super::ShapePoint;
use crate::placement::Placement;

/// The relative displacement to either side \[m, rad\]. The geometry has an error of half its square times
/// its third derivative, and rounding of 1e-10.
const MOVE: f64 = 1e-6;

/// The derivative of a contact's point and axes by a displacement of the first body relative to the second.
/// The displacements are translations along x, y and z, then rotations about these axes through the point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameVariation {
    at: [Vector3<f64>; 6],
    axes: [[Vector3<f64>; 3]; 6],
}

impl FrameVariation {
    /// Computes the derivative by central differences of the geometry: `point` finds the contact in a
    /// placement. The bodies are those of the first and the second shape, or the world.
    pub(super) fn new(
        placement: &mut Placement,
        bodies: [usize; 2],
        at: Vector3<f64>,
        point: impl Fn(&Placement) -> ShapePoint,
    ) -> Self {
        let [first, second] = bodies;
        let mut variation = Self::default();
        if first == WORLD && second == WORLD {
            return variation;
        }
        for (k, (by_point, by_axes)) in variation.at.iter_mut().zip(&mut variation.axes).enumerate() {
            let [mut shift, mut turn] = [Vector3::zeros(); 2];
            let moves = if k < 3 { &mut shift } else { &mut turn };
            moves[k % 3] = MOVE;
            // If the first body is fixed, the second moves against the direction, and both are moved back.
            let (body, sign) = if first == WORLD { (second, -1.0) } else { (first, 1.0) };
            let moved = |sign: f64, placement: &mut Placement| {
                placement.with_moved(body, &at, &[shift * sign, turn * sign], &point)
            };
            let (after, before) = (moved(sign, placement), moved(-sign, placement));
            let quotient = |after: Vector3<f64>, before: Vector3<f64>| (after - before) / (2.0 * MOVE);
            *by_point = quotient(after.at, before.at);
            for (r, by_axis) in by_axes.iter_mut().enumerate() {
                *by_axis = quotient(after.axes[r], before.axes[r]);
                if first == WORLD {
                    *by_axis += turn.cross(&after.axes[r].lerp(&before.axes[r], 0.5)) / MOVE;
                }
            }
            if first == WORLD {
                *by_point += shift / MOVE;
            }
        }
        variation
    }

    /// The change of the point and of the axes for a motion of the bodies. `relative` is the motion
    /// of the first body relative to the second. A motion is the velocity of the contact point and ω.
    pub(super) fn of_motion(
        &self,
        axes: &[Vector3<f64>; 3],
        relative: [Vector3<f64>; 2],
        second: [Vector3<f64>; 2],
    ) -> (Vector3<f64>, [Vector3<f64>; 3]) {
        let [shift, turn] = relative;
        let mut at = second[0];
        let mut by_axes = axes.map(|axis| second[1].cross(&axis));
        for (k, rate) in shift.iter().chain(&turn).enumerate().filter(|(_, rate)| **rate != 0.0) {
            at += self.at[k] * *rate;
            by_axes.iter_mut().zip(&self.axes[k]).for_each(|(sum, axis)| *sum += axis * *rate);
        }
        (at, by_axes)
    }
}
