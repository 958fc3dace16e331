//! Reference points: their positions, and the shift of quantities between them.
//!
//! See `model::reference_point`.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{Sym3, V3};

use crate::Model;
use crate::model::Body;
use crate::model::reference_point::ReferencePoints;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{MassFlux, SpatialInertia};
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::TreeMemory;

/// The vector from the main reference point to a body's. Call after
/// [`compute_columns`](crate::kinematics::world_frame::compute_columns).
#[inline(always)]
pub(crate) fn from_main<S: Scalar>(model: &Model, tree: &TreeMemory<S>, body: usize) -> V3<S> {
    let (Body { point, tree: root, .. }, ReferencePoints { main, main_tree, .. }) =
        (&model.bodies[body], &model.points);
    // Within a tree, offsets do not involve the world's origin.
    let mut offset = from_root(tree, *point, *root) - from_root(tree, *main, *main_tree);
    if root != main_tree {
        offset += tree.world.points[*root] - tree.world.points[*main_tree];
    }
    offset
}

/// The position of a body's reference point in the world.
#[inline(always)]
pub fn in_world<S: Scalar>(model: &Model, tree: &TreeMemory<S>, body: usize) -> V3<S> {
    let Body { point, tree: root, .. } = &model.bodies[body];
    tree.world.points[*root] + from_root(tree, *point, *root)
}

/// The position of the main reference point in the world.
#[inline(always)]
pub(crate) fn main_in_world<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> V3<S> {
    let ReferencePoints { main, main_tree, .. } = model.points;
    tree.world.points[main_tree] + from_root(tree, main, main_tree)
}

/// The vector from the reference point of a tree's root to another one.
#[inline(always)]
fn from_root<S: Scalar>(tree: &TreeMemory<S>, point: usize, root: usize) -> V3<S> {
    if point == root { V3::zero() } else { tree.world.points[point] }
}

/// The vector from the reference point of a body to that of its descendant.
#[inline(always)]
pub(crate) fn lever_between<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    carrier: usize,
    mut body: usize,
) -> V3<S> {
    let mut lever = V3::zero();
    while model.points.carried && body != carrier {
        if model.bodies[body].shifts_reference_point {
            lever += tree.world.levers[model.bodies[body].point];
        }
        body = model.bodies[body].parent;
    }
    lever
}

/// Moves a parent's motion from the parent's reference point to the body's.
#[inline(always)]
pub(crate) fn pass_outward<S: Scalar>(body: &Body, levers: &[V3<S>], motion: &mut MotionVector<S>) {
    if body.shifts_reference_point {
        motion.linear += motion.angular.cross(levers[body.point]);
    }
}

/// Moves a force from a body's reference point to its parent's.
#[inline(always)]
pub(crate) fn pass_inward<S: Scalar>(body: &Body, levers: &[V3<S>], force: &mut ForceVector<S>) {
    if body.shifts_reference_point {
        force.angular += levers[body.point].cross(force.linear);
    }
}

/// Moves an inertia from a body's reference point to its parent's. **(RBDA §2.13)**
#[inline(always)]
pub(crate) fn pass_inertia<S: Scalar>(body: &Body, levers: &[V3<S>], whole: &mut SpatialInertia<S>) {
    if body.shifts_reference_point {
        let d = levers[body.point];
        // I + 2(d·g)1 − (d gᵀ + g dᵀ) with g = h + ½ m d.
        let g = whole.first_moment.add_scaled(whole.mass.scale(0.5), d);
        let inertia = whole.inertia.full().minus_outer(d, g).minus_outer(g, d);
        whole.inertia = Sym3::from_columns(&inertia).plus_multiple_of_identity(d.dot(g).scale(2.0));
        whole.first_moment = whole.first_moment.add_scaled(whole.mass, d);
    }
}

/// Moves a flow ∫ ṗ pᵀ dm from a body's reference point to its parent's: ∫ ṗ (p + d)ᵀ dm.
#[inline(always)]
pub(crate) fn pass_flow<S: Scalar>(body: &Body, levers: &[V3<S>], flow: &mut MassFlux<S>) {
    if body.shifts_reference_point {
        flow.first_moment_rate = flow.first_moment_rate.minus_outer(flow.momentum, -levers[body.point]);
    }
}
