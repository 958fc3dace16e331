//! Forward dynamics: by the articulated-body algorithm, O(n), and by Cholesky.
//!
//! Inward, each body's articulated inertia Iᴬ and bias force pᴬ say what force its handle needs,
//! F = Iᴬ a + pᴬ, with the joints beyond free to move; eliminating one freedom s leaves
//! Iᵃ = Iᴬ − U Uᵀ/d, U = Iᴬ s, d = sᵀU + armature. Outward, q̈ = (u − Uᵀa)/d. **(RBDA §7.3)**
//! Accelerations are classical ones of the frame origins, so that no linear velocity is needed; a joint of
//! several freedoms is eliminated one freedom at a time, at the same place.

use dynamics::Scalar;

use crate::algebra::{M3, Sym3, V3};
use crate::inverse_dynamics::bias;
use crate::mass_matrix::mass_matrix;
use crate::model::{Body, Motion, WORLD};
use crate::place::{check_length, place_bodies, spread};
use crate::workspace::{Articulated, Force, Pivot, Place};
use crate::wrench::{FrameWrench, subtract_wrenches};
use crate::{Model, Workspace, sparse_cholesky};

/// a = M⁻¹(τ − C v − g): the acceleration under the generalized forces τ. **(RBDA §7.3)**
///
/// Damping and friction are not in it: subtract [`dissipation`](crate::dissipation) from τ. A robot with
/// followers (mimic) is no tree any more; it goes through M and Cholesky instead.
///
/// A pose with a singular M gives non-finite accelerations;
/// [`Model::forward_dynamics`](crate::Model::forward_dynamics) reports them as an error.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "ABA")]
#[inline]
pub fn forward_dynamics<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    acceleration: &mut [S],
) {
    if model.has_mimic {
        forward_dynamics_by_cholesky(model, workspace, q, v, tau, acceleration);
    } else {
        articulated_body(model, workspace, q, v, tau, &[], acceleration);
    }
}

/// a = M⁻¹(τ + Σ Jᵀw − C v − g): forward dynamics under external wrenches w acting on frames.
///
/// # Panics
/// If a slice has the wrong length.
pub fn forward_dynamics_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    acceleration: &mut [S],
) {
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    if model.has_mimic {
        // τ − (ID at a = 0 under the wrenches), then M a = that.
        let mut vector = core::mem::take(&mut workspace.vector);
        acceleration.fill(S::zero());
        let zero: &[S] = acceleration;
        crate::inverse_dynamics_with_wrenches(model, workspace, q, v, zero, wrenches, &mut vector);
        solve_with_mass(model, workspace, q, tau, &vector, acceleration);
        workspace.vector = vector;
    } else {
        articulated_body(model, workspace, q, v, tau, wrenches, acceleration);
    }
}

/// The same acceleration by another route: M from the composite-rigid-body algorithm, C v + g from the
/// Newton–Euler recursion, then M = LᵀL, which keeps the tree's zeros. The oracle of
/// [`forward_dynamics`].
///
/// # Panics
/// If a slice has the wrong length.
pub fn forward_dynamics_by_cholesky<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    acceleration: &mut [S],
) {
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    let mut vector = core::mem::take(&mut workspace.vector);
    bias(model, workspace, q, v, &mut vector);
    solve_with_mass(model, workspace, q, tau, &vector, acceleration);
    workspace.vector = vector;
}

fn solve_with_mass<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    tau: &[S],
    bias: &[S],
    acceleration: &mut [S],
) {
    let mut matrix = core::mem::take(&mut workspace.matrix);
    mass_matrix(model, workspace, q, &mut matrix);
    for ((a, &tau), &bias) in acceleration.iter_mut().zip(tau).zip(bias) {
        *a = tau - bias;
    }
    sparse_cholesky::factor(&workspace.carrier, &mut matrix);
    sparse_cholesky::solve(&workspace.carrier, &matrix, acceleration);
    workspace.matrix = matrix;
}

#[inline(always)]
fn articulated_body<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    acceleration: &mut [S],
) {
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    place_bodies(model, workspace, q);
    spread(model, v, &mut workspace.v);
    outward_velocities(model, workspace, wrenches);
    inward_inertias(model, workspace, tau);
    outward_accelerations(model, workspace, acceleration);
}

/// ω of each body, the rigid-body inertia as the first articulated one, its bias force, and the
/// acceleration that the velocities alone cause (kept in `motion.origin` and `motion.alpha`).
#[inline(always)]
fn outward_velocities<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, wrenches: &[FrameWrench<S>]) {
    for (i, body) in model.bodies.iter().enumerate() {
        let angular_of_parent =
            if body.parent == WORLD { V3::zero() } else { workspace.motion[body.parent].angular };
        let place = &workspace.place[i];
        let turned = place.rotation.transpose_mul(angular_of_parent);
        // ω_p × (ω_p × p), in the parent's frame.
        let p = place.translation;
        let centripetal =
            angular_of_parent * angular_of_parent.dot(p) - p * angular_of_parent.dot(angular_of_parent);
        let bias = velocity_acceleration(body, turned, place, centripetal, &workspace.v[body.dof..]);
        let motion = &mut workspace.motion[i];
        motion.angular = bias.angular;
        motion.origin = bias.origin;
        motion.alpha = bias.alpha;
        let w = bias.angular;
        let h = V3::from_f64(body.first_moment.0);
        let inertia = Sym3::from_f64(body.inertia.0);
        let o = S::zero();
        let m = S::from_f64(body.mass);
        workspace.force[i] = Force { linear: w * w.dot(h) - h * w.dot(w), angular: w.cross(inertia * w) };
        workspace.articulated[i] = Articulated {
            mass: Sym3([m, o, o, m, o, m]),
            coupling: M3::skew(-h),
            inertia,
            bias: Force::zero(),
        };
    }
    subtract_wrenches(model, &mut workspace.force, wrenches);
    for (articulated, force) in workspace.articulated.iter_mut().zip(&workspace.force) {
        articulated.bias = *force;
    }
}

struct VelocityAcceleration<S> {
    angular: V3<S>,
    origin: V3<S>,
    alpha: V3<S>,
}

/// The body's ω, and the acceleration of its frame at q̈ = 0 relative to the parent's, in its own frame.
#[inline(always)]
fn velocity_acceleration<S: Scalar>(
    body: &Body,
    turned: V3<S>,
    place: &Place<S>,
    centripetal: V3<S>,
    v: &[S],
) -> VelocityAcceleration<S> {
    let mut angular = turned;
    let mut alpha = V3::zero();
    let mut origin = place.rotation.transpose_mul(centripetal);
    let [wx, wy, _] = turned.0;
    let o = S::zero();
    match body.motion {
        Motion::Revolute => {
            angular.0[2] += v[0];
            alpha = V3([wy * v[0], -(wx * v[0]), o]);
        }
        Motion::Prismatic => {
            let twice = v[0] + v[0];
            origin += V3([wy * twice, -(wx * twice), o]);
        }
        Motion::Helical(pitch) => {
            let twice = (v[0] + v[0]).scale(pitch);
            angular.0[2] += v[0];
            alpha = V3([wy * v[0], -(wx * v[0]), o]);
            origin += V3([wy * twice, -(wx * twice), o]);
        }
        Motion::Spherical => {
            let w = V3([v[0], v[1], v[2]]);
            angular += w;
            alpha = turned.cross(w);
        }
        Motion::Floating => {
            let (u, w) = (V3([v[0], v[1], v[2]]), V3([v[3], v[4], v[5]]));
            angular += w;
            alpha = turned.cross(w);
            origin += (angular + turned).cross(u);
        }
    }
    VelocityAcceleration { angular, origin, alpha }
}

/// Eliminates the freedoms from the leaves to the root.
#[inline(always)]
fn inward_inertias<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, tau: &[S]) {
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let mut articulated = workspace.articulated[i];
        let motion = &workspace.motion[i];
        // pᴬ + Iᴬ c: the bias with the velocity-caused acceleration folded in.
        articulated.bias.linear += articulated.mass * motion.origin + articulated.coupling * motion.alpha;
        articulated.bias.angular +=
            articulated.coupling.transpose_mul(motion.origin) + articulated.inertia * motion.alpha;
        for k in (0..body.motion.nv()).rev() {
            let dof = &model.dofs[body.dof + k];
            let mut force = tau[dof.coordinate];
            if dof.passive.stiffness != 0.0 {
                let stretch = workspace.angle[i] - S::from_f64(dof.passive.rest);
                force -= stretch.scale(dof.passive.stiffness);
            }
            workspace.pivot[body.dof + k] =
                eliminate(body.motion, k, &mut articulated, force, S::from_f64(dof.passive.armature));
        }
        if body.parent != WORLD {
            add_to_parent(&workspace.place[i], &articulated, &mut workspace.articulated[body.parent]);
        }
    }
}

/// Iᵃ = Iᴬ − U Uᵀ/d, pᵃ = pᴬ + U u/d, in place.
#[inline(always)]
fn eliminate<S: Scalar>(motion: Motion, k: usize, ia: &mut Articulated<S>, tau: S, armature: S) -> Pivot<S> {
    let column = articulated_column(motion, k, ia);
    let d = crate::mass_matrix::force_along(motion, k, &column) + armature;
    let inverse = S::one() / d;
    let residual = tau - crate::mass_matrix::force_along(motion, k, &ia.bias);
    let (f, n) = (column.linear, column.angular);
    let (fd, nd) = (f * inverse, n * inverse);
    let outer = |a: &V3<S>, b: &V3<S>| {
        let entry = |i: usize, j: usize| -(a.0[i] * b.0[j]);
        Sym3([entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)])
    };
    ia.mass = ia.mass + outer(&f, &fd);
    ia.inertia = ia.inertia + outer(&n, &nd);
    ia.coupling =
        M3(core::array::from_fn(|i| core::array::from_fn(|j| ia.coupling.0[i][j] - f.0[i] * nd.0[j])));
    ia.bias.linear += fd * residual;
    ia.bias.angular += nd * residual;
    Pivot { column, inverse, residual }
}

/// U = Iᴬ s.
#[inline(always)]
fn articulated_column<S: Scalar>(motion: Motion, k: usize, ia: &Articulated<S>) -> Force<S> {
    let about =
        |axis: usize| Force { linear: ia.coupling.column(axis), angular: ia.inertia.full().row(axis) };
    let along = |axis: usize| Force { linear: ia.mass.full().row(axis), angular: ia.coupling.row(axis) };
    match motion {
        Motion::Revolute => about(2),
        Motion::Prismatic => along(2),
        Motion::Helical(pitch) => {
            let (turn, slide) = (about(2), along(2));
            let pitch = S::from_f64(pitch);
            Force {
                linear: turn.linear.add_scaled(pitch, slide.linear),
                angular: turn.angular.add_scaled(pitch, slide.angular),
            }
        }
        Motion::Spherical => about(k),
        Motion::Floating if k < 3 => along(k),
        Motion::Floating => about(k - 3),
    }
}

/// Turns and shifts an articulated inertia to the parent's frame and adds it there:
/// H′ = H − M\[p\]×, I′ = I + \[p\]×H′ − Hᵀ\[p\]×.
#[inline(always)]
fn add_to_parent<S: Scalar>(place: &Place<S>, child: &Articulated<S>, parent: &mut Articulated<S>) {
    let r = &place.rotation;
    let p = M3::skew(place.translation);
    let mass = child.mass.rotated(r);
    let coupling = r.times(&child.coupling).times(&r.transpose());
    let inertia = child.inertia.rotated(r);
    let shifted = coupling - mass.full().times(&p);
    // The sum below is symmetric; its upper triangle is all there is to compute.
    let turn = p.times(&shifted) - coupling.transpose().times(&p);
    let linear = *r * child.bias.linear;
    parent.mass = parent.mass + mass;
    parent.coupling = parent.coupling + shifted;
    parent.inertia = parent.inertia + inertia + Sym3::from_full(&turn);
    parent.bias.angular += *r * child.bias.angular + place.translation.cross(linear);
    parent.bias.linear += linear;
}

/// q̈ from the root to the leaves.
#[inline(always)]
fn outward_accelerations<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, acceleration: &mut [S]) {
    let ground = V3::from_f64(model.gravity().map(|g| -g));
    for (i, body) in model.bodies.iter().enumerate() {
        let (origin, alpha) = if body.parent == WORLD {
            (ground, V3::zero())
        } else {
            (workspace.motion[body.parent].origin, workspace.motion[body.parent].alpha)
        };
        let place = &workspace.place[i];
        let mut force = Force {
            linear: place.rotation.transpose_mul(origin + alpha.cross(place.translation)),
            angular: place.rotation.transpose_mul(alpha),
        };
        for k in 0..body.motion.nv() {
            let pivot = &workspace.pivot[body.dof + k];
            let a = (pivot.residual - pivot.column.dot(&force)) * pivot.inverse;
            acceleration[body.dof + k] = a;
            add_along(body.motion, k, a, &mut force);
        }
        let motion = &mut workspace.motion[i];
        motion.origin += force.linear;
        motion.alpha += force.angular;
    }
}

/// Adds s a to an acceleration.
#[inline(always)]
fn add_along<S: Scalar>(motion: Motion, k: usize, a: S, to: &mut Force<S>) {
    match motion {
        Motion::Revolute => to.angular.0[2] += a,
        Motion::Prismatic => to.linear.0[2] += a,
        Motion::Helical(pitch) => {
            to.angular.0[2] += a;
            to.linear.0[2] += a.scale(pitch);
        }
        Motion::Spherical => to.angular.0[k] += a,
        Motion::Floating if k < 3 => to.linear.0[k] += a,
        Motion::Floating => to.angular.0[k - 3] += a,
    }
}
