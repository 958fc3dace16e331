//! The Newton–Euler recursion with every vector along the world's axes.
//!
//! In body frames each step waits for the rotation of the previous body's vectors. Along the world's axes
//! only the rotations R are propagated by products; ω, α, the acceleration a of the origins and the forces
//! are sums. The other terms of a body do not depend on its neighbours. This takes more operations, but the
//! chain of dependent operations is a third as long. With r the vector from the parent's origin to the
//! body's,
//!
//! ω = ω_p + z v, α = α_p + z v̇ + ω_p × z v, a = a_p + α_p × r + ω_p × (ω_p × r).
//!
//! F = m a + α × h + ω × (ω × h), N = h × a + R (I Rᵀα + Rᵀω × I Rᵀω), and N_p gains N + r × F.
//!
//! Source: RBDA §5.3; Luh, Walker, Paul 1980.

use robot_dynamics_number::algebra::{M3, V3};
use robot_dynamics_number::{Scalar, View};

use crate::Model;
use crate::kinematics::placement::place_body;
use crate::kinematics::wrench::{FrameWrench, subtract_wrenches};
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::AxisMotion;
use crate::workspace::tree::TreeMemory;

/// The outward pass: each body's rotation, offset r and motion along the world's axes, and the force that
/// this motion needs. The world's acceleration is `ground` = −gravity. Reads the angles and `tree.dofs`.
///
/// The forces have their own loop because nothing in the outward pass depends on them. The processor can then
/// overlap the forces of several bodies.
#[inline(always)]
pub(crate) fn accelerate_bodies<N: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    ground: [f64; 3],
) {
    let n = model.bodies.len();
    let (bodies, v, a) = (&model.bodies[..n], &tree.dofs.v[..], &tree.dofs.a[..]);
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (world, motions) = (&mut tree.world.pose[..n], &mut tree.bodies.axis_motion[..n]);
    let force = &mut tree.bodies.force[..n];
    let still = AxisMotion { angular: V3::zero(), alpha: V3::zero(), origin: V3::from_f64(ground) };
    if n == 0 {
        return;
    }
    // The previous body is mostly the parent. Local variables avoid a load from memory. Before the first, see
    // `compute_columns`.
    let (mut last_turn, mut last) = (world[0].rotation, motions[0]);
    for i in 0..n {
        let body = &bodies[i];
        let own = place_body(body, angle[i], sine[i], cosine[i], q);
        let (turn, mut moves) = if body.parent == WORLD {
            world[i].translation = own.translation;
            (own.rotation, still)
        } else {
            let (turn, parent) = if body.parent + 1 == i {
                (last_turn, last)
            } else {
                (world[body.parent].rotation, motions[body.parent])
            };
            let offset = turn * own.translation;
            let (angular, alpha) = (parent.angular, parent.alpha);
            let swing = alpha.cross_sum(offset, angular, angular.cross(offset));
            world[i].translation = offset;
            (turn.times(&own.rotation), AxisMotion { angular, alpha, origin: parent.origin + swing })
        };
        body.motion.accelerate_in_world(&turn, &v[body.dof..], &a[body.dof..], &mut moves);
        world[i].rotation = turn;
        motions[i] = moves;
        (last_turn, last) = (turn, moves);
    }
    for i in 0..n {
        force[i] = motions[i].force(&bodies[i], &world[i].rotation);
    }
}

impl<S: Scalar> AxisMotion<S> {
    /// F and N of one body.
    #[inline(always)]
    fn force(&self, body: &Body, turn: &M3<S>) -> ForceVector<S> {
        let (angular, alpha) = (self.angular, self.alpha);
        let h = *turn * V3::constant(&body.first_moment);
        let linear = alpha.cross_sum(h, angular, angular.cross(h));
        let (back, inertia) = (turn.transpose(), M3::constant(&body.inertia));
        let (own_angular, own_alpha) = (back * angular, back * alpha);
        let spin = inertia.times_plus(own_alpha, own_angular.cross(inertia * own_angular));
        ForceVector {
            linear: linear.add_scaled(S::from_f64(body.mass), self.origin),
            angular: turn.times_plus(spin, h.cross(self.origin)),
        }
    }
}

/// Subtracts external wrenches from the forces; overwrites the workspace's `beyond`.
#[inline(always)]
pub(super) fn subtract_external<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    wrenches: &[FrameWrench<S>],
) {
    if wrenches.is_empty() {
        return;
    }
    tree.bodies.subtree_force.fill(ForceVector::zero());
    subtract_wrenches(model, &mut tree.bodies.subtree_force, wrenches);
    for ((force, own), place) in
        tree.bodies.force.iter_mut().zip(&tree.bodies.subtree_force).zip(&tree.world.pose)
    {
        force.linear += place.rotation * own.linear;
        force.angular += place.rotation * own.angular;
    }
}

/// The inward pass: sums forces towards the root and projects them on the DoFs.
#[inline(always)]
pub(super) fn collect_forces<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world) = (&model.bodies[..n], &tree.world.pose[..n]);
    let (forces, tau) = (&mut tree.bodies.force[..n], &mut tree.dofs.tau[..]);
    // The contribution of body i + 1 to body i.
    let mut from_child = ForceVector::zero();
    for i in (0..n).rev() {
        let (body, mut force, turn) = (&bodies[i], forces[i], &world[i].rotation);
        force.add(&from_child);
        body.motion.forces_in_world(turn, &force, &mut tau[body.dof..]);
        force.angular += world[i].translation.cross(force.linear);
        from_child = ForceVector::zero();
        if body.parent.wrapping_add(1) == i {
            from_child = force;
        } else if body.parent != WORLD {
            forces[body.parent].add(&force);
        }
    }
}
