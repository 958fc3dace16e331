//! From one reference point to another: where they are, and what passes from body to body between them.
//!
//! See [`reference_point`](crate::model::reference_point).

use dynamics::Scalar;

use crate::Model;
use crate::model::Body;
use crate::model::reference_point::ReferencePoints;
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::{Sym3, V3};
use crate::spatial::screw::{Composite, Flow, Force, Screw};

/// Where a body's reference point is, seen from the main one, after
/// [`place_screws`](crate::stages::screws::place_screws).
#[inline(always)]
pub(crate) fn from_main<S: Scalar>(model: &Model, tree: &TreeMemory<S>, body: usize) -> V3<S> {
    let (Body { point, tree: root, .. }, ReferencePoints { main, main_tree, .. }) =
        (&model.bodies[body], &model.points);
    // Within a tree nothing is measured from the world's origin.
    let mut offset = from_root(tree, *point, *root) - from_root(tree, *main, *main_tree);
    if root != main_tree {
        offset += tree.screws.points[*root] - tree.screws.points[*main_tree];
    }
    offset
}

/// Where a body's reference point is in the world.
#[inline(always)]
pub(crate) fn in_world<S: Scalar>(model: &Model, tree: &TreeMemory<S>, body: usize) -> V3<S> {
    let Body { point, tree: root, .. } = &model.bodies[body];
    tree.screws.points[*root] + from_root(tree, *point, *root)
}

/// Where the main reference point is in the world.
#[inline(always)]
pub(crate) fn main_in_world<S: Scalar>(model: &Model, tree: &TreeMemory<S>) -> V3<S> {
    let ReferencePoints { main, main_tree, .. } = model.points;
    tree.screws.points[main_tree] + from_root(tree, main, main_tree)
}

/// A reference point from that of its tree's root.
#[inline(always)]
fn from_root<S: Scalar>(tree: &TreeMemory<S>, point: usize, root: usize) -> V3<S> {
    if point == root { V3::zero() } else { tree.screws.points[point] }
}

/// From the reference point of a body to that of one that it carries.
#[inline(always)]
pub(crate) fn lever_between<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    carrier: usize,
    mut body: usize,
) -> V3<S> {
    let mut lever = V3::zero();
    while model.points.carried && body != carrier {
        if model.bodies[body].is_carried {
            lever += tree.screws.levers[model.bodies[body].point];
        }
        body = model.bodies[body].parent;
    }
    lever
}

/// The motion that a body's parent passes on: from the parent's point to the body's.
#[inline(always)]
pub(crate) fn pass_outward<S: Scalar>(body: &Body, levers: &[V3<S>], motion: &mut Screw<S>) {
    if body.is_carried {
        motion.linear += motion.angular.cross(levers[body.point]);
    }
}

/// The force that a body passes on to its parent: from the body's point to the parent's.
#[inline(always)]
pub(crate) fn pass_inward<S: Scalar>(body: &Body, levers: &[V3<S>], force: &mut Force<S>) {
    if body.is_carried {
        force.angular += levers[body.point].cross(force.linear);
    }
}

/// The inertia that a body passes on to its parent. **(RBDA §2.13)**
#[inline(always)]
pub(crate) fn pass_inertia<S: Scalar>(body: &Body, levers: &[V3<S>], whole: &mut Composite<S>) {
    if body.is_carried {
        let d = levers[body.point];
        // I + 2(d·g)1 − (d gᵀ + g dᵀ) with g = h + ½ m d.
        let g = whole.first_moment.add_scaled(whole.mass.scale(0.5), d);
        let inertia = whole.inertia.full().minus_outer(d, g).minus_outer(g, d);
        whole.inertia = Sym3::from_columns(&inertia).plus_multiple_of_identity(d.dot(g).scale(2.0));
        whole.first_moment = whole.first_moment.add_scaled(whole.mass, d);
    }
}

/// The flow that a body passes on to its parent: ∫ ṗ (p + d)ᵀ dm.
#[inline(always)]
pub(crate) fn pass_flow<S: Scalar>(body: &Body, levers: &[V3<S>], flow: &mut Flow<S>) {
    if body.is_carried {
        flow.stir = flow.stir.minus_outer(flow.momentum, -levers[body.point]);
    }
}
