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

mod along_world_axes;

use dynamics::Scalar;

use crate::algebra::{M3, Padded, V3};
use crate::dispatch::{Route, Task, run};
use crate::mass_matrix::{force_along, force_in_parent};
use crate::model::{Body, Motion, WORLD};
use crate::place::{check_length, evaluate_angles, gather_by, place_body, spread_by, turned_back};
use crate::workspace::{BodyMotion, Force, Place};
use crate::wrench::{FrameWrench, subtract_wrenches};
use crate::{Model, Workspace};

/// The outward pass: each body's placement, ω and acceleration field, and the force that this motion takes;
/// with `ground` = −gravity as the world's acceleration. Reads the angles and `workspace.{v, a}`.
#[inline(always)]
pub(crate) fn accelerate_bodies<S: Scalar, R: Route<S>>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    q: &[S],
    ground: [f64; 3],
) {
    let world = BodyMotion {
        angular: V3::zero(),
        gradient: M3::zero(),
        origin: V3::from_f64(ground),
        alpha: V3::zero(),
    };
    let n = model.bodies.len();
    let (bodies, v, a) = (&model.bodies[..n], &workspace.v[..], &workspace.a[..]);
    let (angle, sine, cosine) = (&workspace.angle[..n], &workspace.sine[..n], &workspace.cosine[..n]);
    let (place, motion) = (&mut workspace.place[..n], &mut workspace.motion[..n]);
    let force = &mut workspace.force[..n];
    for i in 0..n {
        let body = &bodies[i];
        place[i] = place_body::<S, R>(body, angle[i], sine[i], cosine[i], q);
        let back = turned_back(body, &place[i], sine[i], cosine[i]);
        let parent = if body.parent == WORLD { &world } else { &motion[body.parent] };
        let own = accelerate_body(body, parent, &place[i], &back, &v[body.dof..], &a[body.dof..]);
        force[i] = inertial_force(body, &own);
        motion[i] = own;
    }
}

#[inline(always)]
fn accelerate_body<S: Scalar>(
    body: &Body,
    parent: &BodyMotion<S>,
    place: &Place<S>,
    back: &M3<S>,
    v: &[S],
    a: &[S],
) -> BodyMotion<S> {
    let p = parent.gradient * place.translation + parent.origin;
    // The parent's ω and α, and its field at this body's origin, turned into this body's frame.
    let turned = turn_back(place, back, parent.angular);
    let mut angular = turned;
    let mut alpha = turn_back(place, back, parent.alpha);
    let mut origin = turn_back(place, back, p);
    match body.motion {
        Motion::Revolute => {
            // α = α_p + ω_p × e_z v + e_z a.
            angular.bump_z(v[0]);
            alpha += turned.cross_z(v[0]);
            alpha.bump_z(a[0]);
        }
        Motion::Prismatic => {
            // Coriolis: 2 ω × e_z v.
            origin += turned.cross_z(v[0] + v[0]);
            origin.bump_z(a[0]);
        }
        Motion::Helical(pitch) => {
            angular.bump_z(v[0]);
            alpha += turned.cross_z(v[0]);
            alpha.bump_z(a[0]);
            origin += turned.cross_z((v[0] + v[0]).scale(pitch));
            origin.bump_z(a[0].scale(pitch));
        }
        Motion::Spherical => {
            let w = V3::new([v[0], v[1], v[2]]);
            angular += w;
            alpha += turned.cross(w) + V3::new([a[0], a[1], a[2]]);
        }
        Motion::Floating => {
            // Velocity u and w are measured in this frame, which turns with ω: u̇ gains ω × u.
            let (u, w) = (V3::new([v[0], v[1], v[2]]), V3::new([v[3], v[4], v[5]]));
            angular += w;
            alpha += turned.cross(w) + V3::new([a[3], a[4], a[5]]);
            origin += (angular + turned).cross(u) + V3::new([a[0], a[1], a[2]]);
        }
    }
    BodyMotion { angular, gradient: M3::spin_gradient(angular, alpha), origin, alpha }
}

/// Rᵀ x, by whichever form the scalar multiplies faster.
#[inline(always)]
fn turn_back<S: Scalar>(place: &Place<S>, back: &M3<S>, x: V3<S>) -> V3<S> {
    if M3::<S>::KEEPS_TRANSPOSE { *back * x } else { place.rotation.transpose_mul(x) }
}

/// The force that gives a body its acceleration: F = m a_o + B h, N = h × a_o + axial(B Σ).
#[inline(always)]
pub(crate) fn inertial_force<S: Scalar>(body: &Body, motion: &BodyMotion<S>) -> Force<S> {
    let h = V3::constant(&body.first_moment);
    let linear = (motion.gradient * h).add_scaled(S::from_f64(body.mass), motion.origin);
    let spin = if M3::<S>::KEEPS_TRANSPOSE {
        // The same moment as I α + ω × I ω: more products, but no reading across columns.
        let inertia = M3::constant(&body.inertia);
        inertia * motion.alpha + motion.angular.cross(inertia * motion.angular)
    } else {
        let [x, y, z] = motion.gradient.rows();
        let [sx, sy, sz] = &body.second_moment;
        V3::new([along(z, sy) - along(y, sz), along(x, sz) - along(z, sx), along(y, sx) - along(x, sy)])
    };
    Force { linear, angular: h.cross(motion.origin) + spin }
}

/// A row of B times a column of Σ.
#[inline(always)]
fn along<S: Scalar>(row: [S; 3], column: &Padded) -> S {
    row[0].mul_add(S::from_f64(column[0]), row[1].mul_add(S::from_f64(column[1]), row[2].scale(column[2])))
}

/// The inward pass: sums forces towards the root and projects them on the freedoms.
#[inline(always)]
pub(crate) fn collect_forces<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    let n = model.bodies.len();
    let (bodies, place) = (&model.bodies[..n], &workspace.place[..n]);
    let (forces, tau) = (&mut workspace.force[..n], &mut workspace.tau[..]);
    for i in (0..n).rev() {
        let (body, force) = (&bodies[i], forces[i]);
        for k in 0..body.motion.nv() {
            tau[body.dof + k] = force_along(body.motion, k, &force);
        }
        if body.parent != WORLD {
            forces[body.parent].add(&force_in_parent(&place[i], &force));
        }
    }
}

/// The arguments of a Newton–Euler recursion; `v` and `a` may be absent, meaning zero.
pub(crate) struct NewtonEuler<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: Option<&'a [S]>,
    pub a: Option<&'a [S]>,
    /// The world's acceleration: −gravity, or zero.
    pub ground: [f64; 3],
    pub with_springs: bool,
    pub wrenches: &'a [FrameWrench<S>],
    pub tau: &'a mut [S],
}

impl<S: Scalar> Task<S> for NewtonEuler<'_, S> {
    #[inline(always)]
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>) {
        let model = self.model;
        evaluate_angles::<S, R>(model, workspace, self.q);
        match self.v {
            Some(v) => spread_by::<S, R>(model, v, &mut workspace.v),
            None => workspace.v.fill(Scalar::zero()),
        }
        match self.a {
            Some(a) => spread_by::<S, R>(model, a, &mut workspace.a),
            None => workspace.a.fill(Scalar::zero()),
        }
        if M3::<R::Number>::KEEPS_TRANSPOSE {
            along_world_axes::accelerate_bodies::<S, R>(model, workspace, self.q, self.ground);
            along_world_axes::subtract_external::<S, R>(model, workspace, self.wrenches);
            along_world_axes::collect_forces(model, workspace);
        } else {
            accelerate_bodies::<S, R>(model, workspace, self.q, self.ground);
            subtract_wrenches::<S, R>(model, &mut workspace.force, self.wrenches);
            collect_forces(model, workspace);
        }
        if model.has_armature {
            for ((tau, a), dof) in workspace.tau.iter_mut().zip(&workspace.a).zip(&model.dofs) {
                *tau += a.scale(dof.passive.armature);
            }
        }
        if self.with_springs && model.has_springs {
            for (tau, dof) in workspace.tau.iter_mut().zip(&model.dofs) {
                let stretch = workspace.angle[dof.body] - R::Number::from_f64(dof.passive.rest);
                *tau += stretch.scale(dof.passive.stiffness);
            }
        }
        gather_by::<S, R>(model, &workspace.tau, self.tau);
    }
}

/// −(gravitational acceleration): the acceleration a world without gravity would need.
pub(crate) fn upward(model: &Model) -> [f64; 3] {
    model.gravity().map(|g| -g)
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
    let ground = upward(model);
    run(
        workspace,
        NewtonEuler { model, q, v: Some(v), a: Some(a), ground, with_springs: true, wrenches, tau },
    );
}

/// C(q,v) v + g(q): inverse dynamics at a = 0.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "nonlinear effects")]
pub fn bias<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], v: &[S], bias: &mut [S]) {
    check_length("v", v.len(), model.nv);
    check_length("bias", bias.len(), model.nv);
    let ground = upward(model);
    let task =
        NewtonEuler { model, q, v: Some(v), a: None, ground, with_springs: true, wrenches: &[], tau: bias };
    run(workspace, task);
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
    let ground = [0.0; 3];
    let task = NewtonEuler {
        model,
        q,
        v: Some(v),
        a: None,
        ground,
        with_springs: false,
        wrenches: &[],
        tau: product,
    };
    run(workspace, task);
}

/// g(q) = ∂V/∂q: the forces that hold the robot still, against gravity and its springs.
///
/// # Panics
/// If a slice has the wrong length.
pub fn gravity<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], gravity: &mut [S]) {
    check_length("gravity", gravity.len(), model.nv);
    let ground = upward(model);
    let task =
        NewtonEuler { model, q, v: None, a: None, ground, with_springs: true, wrenches: &[], tau: gravity };
    run(workspace, task);
}
