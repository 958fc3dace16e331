//! Bodies along the world's axes, each about its own origin.

use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::{Scalar, View};

use crate::Model;
use crate::kinematics::placement::{evaluate_angles, place_body};
use crate::model::WORLD;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::ArticulatedInertia;
use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;
use crate::workspace::extent::RankBuffers;
use crate::workspace::tree::TreeMemory;

/// Places the bodies at q. Writes each DoF's motion to `column` and each body's inertia to `articulated`.
/// Writes to `world` each body's rotation and p, the vector from its parent's origin to its own.
#[inline(always)]
pub(super) fn place<N: View<f64>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    scratch: &mut RankBuffers,
    q: &[N],
) {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let bodies = &model.bodies[..n];
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (world, columns) = (&mut tree.world.pose[..n], &mut tree.world.column[..]);
    let articulated = &mut tree.inertias.articulated[..n];
    let distance = &mut scratch.distance[..n];
    for i in 0..n {
        let body = &bodies[i];
        let local = place_body(body, angle[i], sine[i], cosine[i], q);
        let placed = if body.parent == WORLD {
            Transform { rotation: local.rotation, translation: V3::zero() }
        } else {
            let carrier = &world[body.parent].rotation;
            distance[i] = local.translation.dot(local.translation).value().sqrt();
            Transform { rotation: carrier.times(&local.rotation), translation: *carrier * local.translation }
        };
        let about_origin = Transform { rotation: placed.rotation, translation: V3::zero() };
        for k in 0..body.motion.nv() {
            columns[body.dof + k] = body.motion.screw(k, &about_origin);
        }
        let own = &mut articulated[i];
        own.mass = Sym3::multiple_of_identity(N::from_f64(body.mass));
        own.coupling = M3::skew(-(placed.rotation * V3::constant(&body.first_moment)));
        own.inertia = Sym3::constant(&body.inertia).rotated(&placed.rotation);
        world[i] = placed;
    }
}

/// I s: the force that gives the body the acceleration s about its origin.
#[inline(always)]
pub(super) fn response<S: Scalar>(inertia: &ArticulatedInertia<S>, s: &MotionVector<S>) -> ForceVector<S> {
    ForceVector {
        linear: inertia.mass * s.linear + inertia.coupling * s.angular,
        angular: inertia.coupling.transpose_mul(s.linear) + inertia.inertia * s.angular,
    }
}

/// Adds a child's inertia to its parent's, about the parent's origin:
/// H′ = H − M\[p\], I′ = I + G + Gᵀ with G = ½\[p\](H + H′). **(RBDA §2.13)**
#[inline(always)]
pub(super) fn add_shifted<S: Scalar>(
    parent: &mut ArticulatedInertia<S>,
    child: &ArticulatedInertia<S>,
    p: V3<S>,
) {
    let coupling = child.coupling - child.mass.full().times(&M3::skew(p));
    let moved = M3::skew(p * S::from_f64(0.5)).times(&(child.coupling + coupling));
    parent.mass = parent.mass + child.mass;
    parent.coupling = parent.coupling + coupling;
    parent.inertia = parent.inertia + child.inertia + Sym3::from_columns(&(moved + moved.transpose()));
}
