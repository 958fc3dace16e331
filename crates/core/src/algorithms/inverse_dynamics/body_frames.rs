//! The Newton–Euler recursion in the bodies' own frames.
//!
//! The outward pass computes each body's angular velocity ω and its field of classical accelerations
//! a(x) = a_o + B x. Both are in the body's frame, and B = \[α\]× + \[ω\]×\[ω\]× (Luh, Walker, Paul 1980). It
//! needs no linear velocity. The inward pass uses m, h = m c and Σ = ∫ r rᵀ dm of each body:
//!
//! force F = m a_o + B h, moment N = h × a_o + ∫ r × (B r) dm, the integral being the axial vector of B Σ.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Padded, V3};

use crate::Model;
use crate::kinematics::placement::place_body;
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, BodyMotion};
use crate::spatial::transform::Transform;
use crate::workspace::tree::TreeMemory;

/// The outward pass: each body's placement, ω and acceleration field, and the force that this motion needs.
/// The world's acceleration is `ground` = −gravity. Reads the angles and `tree.dofs`.
#[inline(always)]
pub(crate) fn accelerate_bodies<N: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    ground: [f64; 3],
) {
    let world = BodyMotion {
        angular: V3::zero(),
        gradient: M3::zero(),
        origin: V3::from_f64(ground),
        alpha: V3::zero(),
    };
    let n = model.bodies.len();
    let (bodies, v, a) = (&model.bodies[..n], &tree.dofs.v[..], &tree.dofs.a[..]);
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (place, motion) = (&mut tree.bodies.place[..n], &mut tree.bodies.motion[..n]);
    let force = &mut tree.bodies.force[..n];
    for i in 0..n {
        let body = &bodies[i];
        place[i] = place_body(body, angle[i], sine[i], cosine[i], q);
        let parent = if body.parent == WORLD { &world } else { &motion[body.parent] };
        let own = accelerate_body(body, parent, &place[i], &v[body.dof..], &a[body.dof..]);
        force[i] = inertial_force(body, &own);
        motion[i] = own;
    }
}

#[inline(always)]
fn accelerate_body<S: Scalar>(
    body: &Body,
    parent: &BodyMotion<S>,
    place: &Transform<S>,
    v: &[S],
    a: &[S],
) -> BodyMotion<S> {
    let p = parent.gradient * place.translation + parent.origin;
    // The parent's ω and α, and its field at this body's origin, rotated into this body's frame.
    let mut own = AxisMotion {
        angular: place.rotation.transpose_mul(parent.angular),
        alpha: place.rotation.transpose_mul(parent.alpha),
        origin: place.rotation.transpose_mul(p),
    };
    body.motion.accelerate(v, a, &mut own);
    let AxisMotion { angular, alpha, origin } = own;
    BodyMotion { angular, gradient: M3::spin_gradient(angular, alpha), origin, alpha }
}

/// The force that gives a body its acceleration: F = m a_o + B h, N = h × a_o + axial(B Σ).
#[inline(always)]
pub(crate) fn inertial_force<S: Scalar>(body: &Body, motion: &BodyMotion<S>) -> ForceVector<S> {
    let h = V3::constant(&body.first_moment);
    let linear = (motion.gradient * h).add_scaled(S::from_f64(body.mass), motion.origin);
    let [x, y, z] = motion.gradient.rows();
    let [sx, sy, sz] = &body.second_moment;
    let spin =
        V3::new([along(z, sy) - along(y, sz), along(x, sz) - along(z, sx), along(y, sx) - along(x, sy)]);
    ForceVector { linear, angular: h.cross(motion.origin) + spin }
}

/// A row of B times a column of Σ.
#[inline(always)]
fn along<S: Scalar>(row: [S; 3], column: &Padded) -> S {
    row[0].mul_add(S::from_f64(column[0]), row[1].mul_add(S::from_f64(column[1]), row[2].scale(column[2])))
}

/// The inward pass: sums forces towards the root and projects them on the DoFs.
#[inline(always)]
pub(crate) fn collect_forces<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, place) = (&model.bodies[..n], &tree.bodies.place[..n]);
    let (forces, tau) = (&mut tree.bodies.force[..n], &mut tree.dofs.tau[..]);
    for i in (0..n).rev() {
        let (body, force) = (&bodies[i], forces[i]);
        for k in 0..body.motion.nv() {
            tau[body.dof + k] = body.motion.force_along(k, &force);
        }
        if body.parent != WORLD {
            forces[body.parent].add(&place[i].force_in_parent(&force));
        }
    }
}
