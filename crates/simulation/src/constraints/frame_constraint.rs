//! Two frames joined: a closed loop, a foot on the floor, a hand on a rail.
//!
//! With d = p_b − p_a and the axes a_k of frame a, a translation has φ = a_k·d. Rotations have products of
//! the axes of both frames. Each row costs O(depth). Three rotational rows are singular
//! at half a turn from a.

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;

use super::anchor::{Anchor, SpatialAxis};
use crate::equality::direction::ConstrainedDirection;
use crate::equality::relation::Relation;

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

    /// The rows between the two sides.
    pub(super) fn relation(&self, model: &Model) -> Relation {
        let turns: Vec<usize> = self.rows.iter().filter(|row| row.is_turn()).map(|row| row.axis()).collect();
        let direction = |row: &SpatialAxis| {
            if row.is_turn() {
                ConstrainedDirection::Turn(products(row.axis(), &turns))
            } else {
                ConstrainedDirection::Shift(row.axis())
            }
        };
        let sites = [&self.a, &self.b].map(|anchor| anchor.site(model));
        Relation::Sites(sites, self.rows.iter().map(direction).collect())
    }

    /// The frames of its sides that are not in the world.
    pub(super) fn frames(&self) -> impl Iterator<Item = FrameId> {
        let frame = |anchor: &Anchor| if let Anchor::Frame(frame) = anchor { Some(*frame) } else { None };
        [&self.a, &self.b].into_iter().filter_map(frame)
    }

    /// The numbers of its sides in the world.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        let pose = |anchor: &Anchor| if let Anchor::World(pose) = anchor { Some(*pose) } else { None };
        let numbers = |pose: Pose| {
            let [x, y, z] = pose.rotation;
            [x, y, z, pose.translation].into_iter().flatten()
        };
        [&self.a, &self.b].into_iter().filter_map(pose).flat_map(numbers)
    }
}

/// The products (c, i, j) with φ_k = Σ c a_i·b_j, for these constrained rotations.
fn products(k: usize, turns: &[usize]) -> Vec<(f64, usize, usize)> {
    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
    match turns.len() {
        2 if !turns.contains(&next) => vec![(1.0, last, next)],
        1 | 2 => vec![(-1.0, next, last)],
        _ => vec![(0.5, last, next), (-0.5, next, last)],
    }
}
