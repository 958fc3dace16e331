//! Two frames joined: a closed loop, a foot on the floor, a hand on a rail.
//!
//! With d = p_b − p_a and the axes a_k of frame a, a translation has φ = a_k·d. Rotations have products of
//! the axes of both frames. Each row costs two frame Jacobians, O(depth). Three rotational rows are singular
//! at half a turn from a.

use nalgebra::Vector3;
use robot_dynamics_core::{FrameId, Model, Workspace};
use robot_dynamics_description::Pose;

use super::anchor::{Anchor, SpatialAxis};
use super::frame_motion::FrameMotion;
use super::rows::RowsAt;

/// Frame b joined to frame a in the directions of the rows.
///
/// With d = p_b − p_a, along a's axes a₀ a₁ a₂ (and b's b₀ b₁ b₂), indices modulo 3:
///
/// | rows chosen | φ | what stays free |
/// | --- | --- | --- |
/// | k of x y z | a_k·d | the directions not chosen |
/// | one turn, k | −a_{k+1}·b_{k+2} | turns about a_{k+1} and b_{k+2}: a universal joint |
/// | two turns, all but m | −a_{m+2}·b_m and a_{m+1}·b_m | a turn about m of any angle: a hinge |
/// | three turns, k | ½(a_{k+2}·b_{k+1} − a_{k+1}·b_{k+2}) | nothing |
///
/// For a small rotation θ of b relative to a, each rotational φ_k is θ_k. A hinge's axis is m of both frames,
/// and its rows are never singular. Three rotational rows are singular at half a turn from a.
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "Closure")]
pub struct FrameConstraint {
    /// The side whose axes the rows are along.
    pub a: Anchor,
    /// The other side.
    pub b: Anchor,
    /// The constrained directions, each at most once.
    pub rows: Vec<SpatialAxis>,
}

impl FrameConstraint {
    /// b's origin coincides with a's: x, y, z.
    pub const BALL: [SpatialAxis; 3] = [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z];
    /// b's origin coincides with a's, and b's z axis is along a's: a hinge about z.
    pub const HINGE: [SpatialAxis; 5] =
        [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry];
    /// b's frame coincides with a's.
    pub const WELD: [SpatialAxis; 6] =
        [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

    /// Frame b joined to frame a.
    pub fn between(a: FrameId, b: FrameId, rows: &[SpatialAxis]) -> Self {
        Self { a: Anchor::Frame(a), b: Anchor::Frame(b), rows: rows.to_vec() }
    }

    /// Fixes the frame's origin to a point of the world: a point contact that sticks.
    pub fn point_contact(frame: FrameId, point_in_world: [f64; 3]) -> Self {
        Self::contact(frame, Pose::from_translation(point_in_world), &Self::BALL)
    }

    /// Fixes the frame to a pose in the world in the given directions; `WELD` is a foot that stands.
    pub fn contact(frame: FrameId, world_from_contact: Pose, rows: &[SpatialAxis]) -> Self {
        Self { a: Anchor::World(world_from_contact), b: Anchor::Frame(frame), rows: rows.to_vec() }
    }

    pub(super) fn write(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        rows: &mut RowsAt<'_>,
    ) {
        let a = FrameMotion::of(model, workspace, q, v, &self.a);
        let b = FrameMotion::of(model, workspace, q, v, &self.b);
        let turns: Vec<usize> = self.rows.iter().filter(|row| row.is_turn()).map(|row| row.axis()).collect();
        for row in &self.rows {
            if row.is_turn() {
                write_turn(&a, &b, &products(row.axis(), &turns), rows);
            } else {
                write_shift(&a, &b, row.axis(), rows);
            }
        }
    }
}

/// φ = a_k·d: with e = a_k, φ̇ = e·(ḋ − ω_a × d), φ̈ = e·(d̈ − ω̇_a × d − 2 ω_a × ḋ + ω_a × (ω_a × d)).
fn write_shift(a: &FrameMotion, b: &FrameMotion, k: usize, rows: &mut RowsAt<'_>) {
    let (e, d, rate) = (a.axis(k), b.position - a.position, b.velocity - a.velocity);
    let row = b.row(&e, &Vector3::zeros()) - a.row(&e, &d.cross(&e));
    let seen_from_a =
        b.bias - a.bias - a.spin_bias.cross(&d) - a.spin.cross(&rate) * 2.0 + a.spin.cross(&a.spin.cross(&d));
    rows.push(&row, e.dot(&seen_from_a), Some(e.dot(&d)));
}

/// φ = Σ c α·β of axes α of a and β of b. With ω = ω_b − ω_a, the rate of α·β is ω·(β × α). Its rate in turn
/// is ω̇·(β × α) + ω·((ω_b × β) × α + β × (ω_a × α)).
fn write_turn(a: &FrameMotion, b: &FrameMotion, products: &[(f64, usize, usize)], rows: &mut RowsAt<'_>) {
    let spin = b.spin - a.spin;
    let (mut normal, mut bias, mut error) = (Vector3::zeros(), 0.0, 0.0);
    for &(c, i, j) in products {
        let (alpha, beta) = (a.axis(i), b.axis(j));
        normal += beta.cross(&alpha) * c;
        bias += c * spin.dot(&(b.spin.cross(&beta).cross(&alpha) + beta.cross(&a.spin.cross(&alpha))));
        error += c * alpha.dot(&beta);
    }
    bias += normal.dot(&(b.spin_bias - a.spin_bias));
    let zero = Vector3::zeros();
    rows.push(&(b.row(&zero, &normal) - a.row(&zero, &normal)), bias, Some(error));
}

/// The products (c, i, j) with φ_k = Σ c a_i·b_j, for these constrained rotations.
pub(super) fn products(k: usize, turns: &[usize]) -> Vec<(f64, usize, usize)> {
    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
    match turns.len() {
        2 if !turns.contains(&next) => vec![(1.0, last, next)],
        1 | 2 => vec![(-1.0, next, last)],
        _ => vec![(0.5, last, next), (-0.5, next, last)],
    }
}
