//! Inverse dynamics by the recursive Newton–Euler algorithm, O(n).
//!
//! Outward: angular velocity ω and the field of classical accelerations a(x) = a_o + B x with
//! B = \[α\]× + \[ω\]×\[ω\]×, each in the body's frame (Luh, Walker, Paul 1980). No linear velocity is
//! needed. Inward: with m, h = m c and Σ = ∫ r rᵀ dm of each body,
//!
//! force F = m a_o + B h, moment N = h × a_o + ∫ r × (B r) dm, the integral being the axial vector of B Σ.
//!
//! Gravity enters as an upward acceleration of the world. Source: RBDA §5.3; Luh, Walker, Paul,
//! *On-line computational scheme for mechanical manipulators*, J. Dyn. Sys. Meas. Control 102 (1980).

use dynamics::Scalar;

use crate::algebra::{M3, Sym3, V3};
use crate::mass_matrix::{force_along, force_in_parent};
use crate::model::{Body, Motion, WORLD};
use crate::place::{check_length, gather, place_bodies, spread};
use crate::workspace::{BodyMotion, Force, Place};
use crate::wrench::{FrameWrench, subtract_wrenches};
use crate::{Model, Workspace};

/// The outward pass: each body's ω and acceleration field; with `ground` = −gravity as the world's
/// acceleration. Reads `workspace.{place, v, a}`.
#[inline(always)]
pub(crate) fn accelerate_bodies<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, ground: [f64; 3]) {
    let world = BodyMotion {
        angular: V3::zero(),
        gradient: M3::zero(),
        origin: V3::from_f64(ground),
        alpha: V3::zero(),
    };
    for (i, body) in model.bodies.iter().enumerate() {
        let parent = if body.parent == WORLD { &world } else { &workspace.motion[body.parent] };
        workspace.motion[i] = accelerate_body(
            body,
            parent,
            &workspace.place[i],
            &workspace.v[body.dof..],
            &workspace.a[body.dof..],
        );
    }
}

#[inline(always)]
fn accelerate_body<S: Scalar>(
    body: &Body,
    parent: &BodyMotion<S>,
    place: &Place<S>,
    v: &[S],
    a: &[S],
) -> BodyMotion<S> {
    let r = &place.rotation;
    // The parent's ω and α, and its field at this body's origin, turned into this body's frame.
    let angular_of_parent = r.transpose_mul(parent.angular);
    let mut angular = angular_of_parent;
    let mut alpha = r.transpose_mul(parent.alpha);
    let mut origin = r.transpose_mul(parent.gradient * place.translation + parent.origin);
    let [wx, wy, _] = angular_of_parent.0;
    match body.motion {
        Motion::Revolute => {
            // α = α_p + ω_p × e_z v + e_z a.
            angular.0[2] += v[0];
            alpha += V3([wy * v[0], -(wx * v[0]), a[0]]);
        }
        Motion::Prismatic => {
            // Coriolis: 2 ω × e_z v.
            let twice = v[0] + v[0];
            origin += V3([wy * twice, -(wx * twice), a[0]]);
        }
        Motion::Helical(pitch) => {
            let twice = (v[0] + v[0]).scale(pitch);
            angular.0[2] += v[0];
            alpha += V3([wy * v[0], -(wx * v[0]), a[0]]);
            origin += V3([wy * twice, -(wx * twice), a[0].scale(pitch)]);
        }
        Motion::Spherical => {
            let w = V3([v[0], v[1], v[2]]);
            angular += w;
            alpha += angular_of_parent.cross(w) + V3([a[0], a[1], a[2]]);
        }
        Motion::Floating => {
            // Velocity u and w are measured in this frame, which turns with ω: u̇ gains ω × u.
            let (u, w) = (V3([v[0], v[1], v[2]]), V3([v[3], v[4], v[5]]));
            angular += w;
            alpha += angular_of_parent.cross(w) + V3([a[3], a[4], a[5]]);
            origin += (angular + angular_of_parent).cross(u) + V3([a[0], a[1], a[2]]);
        }
    }
    BodyMotion { angular, gradient: gradient(angular, alpha), origin, alpha }
}

/// B = \[α\]× + ω ωᵀ − |ω|² 1.
#[inline(always)]
fn gradient<S: Scalar>(w: V3<S>, alpha: V3<S>) -> M3<S> {
    let [wx, wy, wz] = w.0;
    let [ax, ay, az] = alpha.0;
    let (xx, yy, zz) = (wx * wx, wy * wy, wz * wz);
    let (xy, xz, yz) = (wx * wy, wx * wz, wy * wz);
    M3([[-(yy + zz), xy - az, xz + ay], [xy + az, -(xx + zz), yz - ax], [xz - ay, yz + ax, -(xx + yy)]])
}

/// The force that gives a body its acceleration: F = m a_o + B h, N = h × a_o + axial(B Σ).
#[inline(always)]
pub(crate) fn inertial_force<S: Scalar>(body: &Body, motion: &BodyMotion<S>) -> Force<S> {
    let h = V3::from_f64(body.first_moment.0);
    let linear = motion.gradient * h + motion.origin * S::from_f64(body.mass);
    let b = &motion.gradient;
    let sigma = Sym3::from_f64(body.second_moment.0).full();
    let moment = |i: usize, j: usize| b.row(j).dot(sigma.row(i)) - b.row(i).dot(sigma.row(j));
    let angular = h.cross(motion.origin) + V3([moment(1, 2), moment(2, 0), moment(0, 1)]);
    Force { linear, angular }
}

/// The inward pass: sums forces towards the root and projects them on the freedoms.
#[inline(always)]
pub(crate) fn collect_forces<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let force = workspace.force[i];
        for k in 0..body.motion.nv() {
            workspace.tau[body.dof + k] = force_along(body.motion, k, &force);
        }
        if body.parent != WORLD {
            let passed = force_in_parent(&workspace.place[i], &force);
            let parent = &mut workspace.force[body.parent];
            parent.linear += passed.linear;
            parent.angular += passed.angular;
        }
    }
}

/// Everything of the inverse dynamics but copying v and a in.
#[inline(always)]
fn newton_euler<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    ground: [f64; 3],
    wrenches: &[FrameWrench<S>],
    tau: &mut [S],
) {
    accelerate_bodies(model, workspace, ground);
    for (i, body) in model.bodies.iter().enumerate() {
        workspace.force[i] = inertial_force(body, &workspace.motion[i]);
    }
    subtract_wrenches(model, &mut workspace.force, wrenches);
    collect_forces(model, workspace);
    if model.has_armature {
        for ((tau, a), dof) in workspace.tau.iter_mut().zip(&workspace.a).zip(&model.dofs) {
            *tau += a.scale(dof.passive.armature);
        }
    }
    gather(model, &workspace.tau, tau);
}

/// −(gravitational acceleration): the acceleration a world without gravity would need.
fn upward(model: &Model) -> [f64; 3] {
    model.gravity().map(|g| -g)
}

/// Adds the springs' forces, stiffness · (q − rest), to generalized forces.
#[inline(always)]
fn add_springs<S: Scalar>(model: &Model, workspace: &Workspace<S>, tau: &mut [S]) {
    if model.has_springs {
        for dof in model.dofs.iter().filter(|dof| dof.passive.stiffness != 0.0) {
            let stretch = workspace.angle[dof.body] - S::from_f64(dof.passive.rest);
            tau[dof.coordinate] += stretch.scale(dof.passive.stiffness * dof.ratio);
        }
    }
}

/// τ = M(q) a + C(q,v) v + g(q): the generalized forces that produce the acceleration a. **(RBDA §5.3)**
///
/// q has `nq` entries, v, a and tau `nv`; N·m or N. Armature counts in M, springs in g; damping and friction
/// are apart, in [`dissipation`](crate::dissipation).
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "RNEA")]
#[inline]
pub fn inverse_dynamics<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    tau: &mut [S],
) {
    inverse_dynamics_with_wrenches(model, workspace, q, v, a, &[], tau);
}

/// τ = M(q) a + C(q,v) v + g(q) − Σ Jᵀw: inverse dynamics under external wrenches w acting on frames.
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
pub fn inverse_dynamics_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    wrenches: &[FrameWrench<S>],
    tau: &mut [S],
) {
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    place_bodies(model, workspace, q);
    spread(model, v, &mut workspace.v);
    spread(model, a, &mut workspace.a);
    newton_euler(model, workspace, upward(model), wrenches, tau);
    add_springs(model, workspace, tau);
}

/// C(q,v) v + g(q): inverse dynamics at a = 0.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "nonlinear effects")]
pub fn bias<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], v: &[S], bias: &mut [S]) {
    check_length("v", v.len(), model.nv);
    check_length("bias", bias.len(), model.nv);
    place_bodies(model, workspace, q);
    spread(model, v, &mut workspace.v);
    workspace.a.fill(S::zero());
    newton_euler(model, workspace, upward(model), &[], bias);
    add_springs(model, workspace, bias);
}

/// C(q,v) v: the Coriolis and centrifugal forces alone.
///
/// # Panics
/// If a slice has the wrong length.
pub fn velocity_product<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    product: &mut [S],
) {
    check_length("v", v.len(), model.nv);
    check_length("product", product.len(), model.nv);
    place_bodies(model, workspace, q);
    spread(model, v, &mut workspace.v);
    workspace.a.fill(S::zero());
    newton_euler(model, workspace, [0.0; 3], &[], product);
}

/// g(q) = ∂V/∂q: the forces that hold the robot still, against gravity and its springs.
///
/// # Panics
/// If a slice has the wrong length.
pub fn gravity<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], gravity: &mut [S]) {
    check_length("gravity", gravity.len(), model.nv);
    place_bodies(model, workspace, q);
    workspace.v.fill(S::zero());
    workspace.a.fill(S::zero());
    newton_euler(model, workspace, upward(model), &[], gravity);
    add_springs(model, workspace, gravity);
}
