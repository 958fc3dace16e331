//! Forward dynamics by the articulated-body algorithm, O(n).
//!
//! The inward pass finds each body's articulated inertia Iᴬ and bias force pᴬ. The force F = Iᴬ a + pᴬ gives
//! the body the acceleration a while all joints beyond it are free. Eliminating one DoF s leaves
//! Iᵃ = Iᴬ − U Uᵀ/d and pᵃ = pᴬ + U u/d, with U = Iᴬ s, d = sᵀU + armature and u = τ − sᵀpᴬ.
//!
//! The outward pass solves q̈ = (u − Uᵀa)/d. **(RBDA §7.3)** The code uses the same letters. `IA` holds pᴬ as
//! `bias`, and a [`DofElimination`] holds U/d and u/d.
//!
//! All motions and forces are expressed in one inertial frame ([`screws`](crate::kinematics::screws)), so
//! that inertias add without a rotation. A joint of several DoFs is eliminated one DoF at a time.

#![allow(non_snake_case)] // the book's U and Iᴬ

mod in_body_frames;
mod pivots;

#[doc(hidden)]
pub use pivots::inverse_pivots;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::algorithms::forward_dynamics_by_cholesky::accelerate_by_cholesky;
use crate::algorithms::mass_matrix::force_in_parent;
use crate::kinematics::place::{gather, spread};
use crate::kinematics::screws::{
    add_scaled, force_cross, inertia_in_world, momentum_of, motion_cross, move_screws, place_screws,
};
use crate::kinematics::shifts::pass_outward;
use crate::kinematics::wrench::{FrameWrench, subtract_wrenches};
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::spatial::screw::{ArticulatedInertia, DofElimination, Force, SpatialInertia};
use crate::workspace::compiled_once::{OverNumber, compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// a = M⁻¹(τ − C v − g): the acceleration under the generalized forces τ. **(RBDA §7.3)**
///
/// Damping and friction are not included: subtract [`dissipation`](crate::dissipation) from τ. Mimic joints,
/// and armature on tendons over several joints, couple branches, so the system is not a tree. Such a
/// robot takes M and its Cholesky factor instead, O(n³).
///
/// If M is singular, the forces do not determine the acceleration; the result is not finite or meaningless.
/// If this can happen, call [`check_rank`](crate::check_rank) first, or use
/// [`Model::forward_dynamics`](crate::Model::forward_dynamics), which does.
///
/// ```
/// use robot_dynamics::algorithms::forward_dynamics;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut a = [0.0];
/// forward_dynamics(&model, &mut Workspace::new(&model), &[0.3], &[1.0], &[0.7], &mut a);
/// let force = 0.7 + 2.0 * 9.81 * 0.5 * 0.3_f64.cos(); // τ + m g l cos q
/// assert!((a[0] - force / (2.0 * 0.5 * 0.5)).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "ABA")]
#[inline]
#[track_caller]
pub fn forward_dynamics<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    acceleration: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    let (native, function) = (&mut workspace.tree.native, NativeFunction::ForwardDynamics);
    if computed_natively(model, native, function, &[q, v, tau], &mut [&mut *acceleration]) {
        return;
    }
    if model.needs_dense_factor {
        accelerate_by_cholesky(model, workspace, q, v, tau, &[], acceleration);
    } else {
        articulated_body(model, &mut workspace.tree, q, v, tau, &[], acceleration);
    }
}

/// a = M⁻¹(τ + Σ Jᵀw − C v − g): forward dynamics under external wrenches w acting on frames.
///
/// ```
/// use robot_dynamics::algorithms::{FrameWrench, forward_dynamics_with_wrenches};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // A thruster at the tip cancels the weight: the horizontal rod stays at rest.
/// let (frame, mut a) = (model.frame_named("tip")?, [1.0]);
/// let lift = FrameWrench { frame, force_in_frame: [0.0, 0.0, 2.0 * 9.81], moment_in_frame: [0.0; 3] };
/// let w = &mut Workspace::<f64>::new(&model);
/// forward_dynamics_with_wrenches(&model, w, &[0.0], &[0.0], &[0.0], &[lift], &mut a);
/// assert!(a[0].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn forward_dynamics_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    acceleration: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    if wrenches.is_empty() {
        return forward_dynamics(model, workspace, q, v, tau, acceleration);
    }
    if model.needs_dense_factor {
        accelerate_by_cholesky(model, workspace, q, v, tau, wrenches, acceleration);
    } else {
        articulated_body(model, &mut workspace.tree, q, v, tau, wrenches, acceleration);
    }
}

/// The arguments of the articulated-body algorithm.
pub struct ArticulatedBodies<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: &'a [S],
    pub tau: &'a [S],
    pub wrenches: &'a [FrameWrench<S>],
    pub acceleration: &'a mut [S],
}

compiled_once!(pub ArticulatedBodiesKind, ArticulatedBodies);

impl<S: Scalar> Kernel<OverNumber, S> for ArticulatedBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, tau, wrenches, acceleration } = self;
        let (q, v, tau, acceleration) = (N::view(q), N::view(v), N::view(tau), N::view_mut(acceleration));
        spread(model, tau, &mut tree.freedoms.tau);
        if M3::<N>::FOLDS_ZEROS {
            spread(model, v, &mut tree.freedoms.v);
            in_body_frames::accelerate(model, tree, q, wrenches);
            gather(model, &tree.freedoms.a, acceleration);
            return;
        }
        place_screws(model, tree, q);
        move_screws(model, tree, v);
        free_bodies(model, tree);
        subtract_in_world(model, tree, wrenches);
        eliminate_freedoms(model, tree);
        accelerate_freedoms(model, tree);
        gather(model, &tree.freedoms.a, acceleration);
    }
}

fn articulated_body<S: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    acceleration: &mut [S],
) {
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    run(tree, ArticulatedBodies { model, q, v, tau, wrenches, acceleration });
}

/// Initializes each body: its inertia and its bias force V ×\* I V. Writes to `twist_rate` the acceleration
/// V × S v due to its joint's motion at q̈ = 0.
#[inline(always)]
pub fn free_bodies<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world, twists) = (&model.bodies[..n], &tree.screws.world[..n], &tree.screws.twist[..n]);
    let (rates, columns) = (&tree.freedoms.v[..], &tree.screws.column[..]);
    let (twist_rates, articulated) = (&mut tree.screws.twist_rate[..n], &mut tree.inertias.articulated[..n]);
    for i in 0..n {
        let (body, twist) = (&bodies[i], &twists[i]);
        let mut joint = Force::zero();
        for dof in body.dof..body.dof + body.motion.nv() {
            add_scaled(&mut joint, rates[dof], &columns[dof]);
        }
        twist_rates[i] = motion_cross(twist, &joint);
        let inertia = inertia_in_world(body, &world[i]);
        let momentum = momentum_of(&inertia, twist);
        let SpatialInertia { mass, first_moment, inertia } = inertia;
        let own = &mut articulated[i];
        own.mass = Sym3::multiple_of_identity(mass);
        own.coupling = M3::skew(-first_moment);
        if M3::<S>::KEEPS_TRANSPOSE {
            own.coupling_back = M3::skew(first_moment);
        }
        own.inertia = inertia;
        own.bias = force_cross(twist, &momentum);
    }
}

/// Subtracts external wrenches from the bias forces.
#[inline(always)]
pub fn subtract_in_world<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    wrenches: &[FrameWrench<S>],
) {
    if wrenches.is_empty() {
        return;
    }
    tree.bodies.force.fill(Force::zero());
    subtract_wrenches(model, &mut tree.bodies.force, wrenches);
    for ((articulated, force), place) in
        tree.inertias.articulated.iter_mut().zip(&tree.bodies.force).zip(&tree.screws.world)
    {
        articulated.bias.add(&force_in_parent(place, force));
    }
}

/// The inward pass: each DoF's [`DofElimination`], and each body's contribution to its parent.
#[inline(always)]
pub fn eliminate_freedoms<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, twist_rates, angle) =
        (&model.bodies[..n], &tree.screws.twist_rate[..n], &tree.angles.angle[..n]);
    let (tau, columns, pivots) =
        (&tree.freedoms.tau[..], &tree.screws.column[..], &mut tree.inertias.pivot[..]);
    let (all, levers) = (&mut tree.inertias.articulated[..n], &tree.screws.levers[..]);
    for i in (0..n).rev() {
        let body = &bodies[i];
        let mut IA = all[i];
        // pᴬ + Iᴬ c: the bias including the velocity-dependent acceleration.
        let pushed = IA.times(&twist_rates[i]);
        IA.bias.add(&pushed);
        for index in (body.dof..body.dof + body.motion.nv()).rev() {
            let dof = &model.dofs[index];
            let force = less_spring(model, index, tau[index], angle[i]);
            let armature = S::from_f64(dof.passive.armature);
            let (pivot, U, inverse) = IA.pivot(&columns[index], force, armature);
            let last = index == body.dof;
            if last && body.parent != WORLD {
                // Vector registers form the sum while the division is pending. Independent divisions overlap
                // too.
                if body.shifts_reference_point {
                    IA.eliminate(&pivot, &U, inverse);
                    IA.shift(levers[body.point]);
                    all[body.parent].add(&IA);
                } else if M3::<S>::KEEPS_TRANSPOSE {
                    IA.add(&all[body.parent]);
                    IA.eliminate(&pivot, &U, inverse);
                    all[body.parent] = IA;
                } else {
                    IA.eliminate(&pivot, &U, inverse);
                    all[body.parent].add(&IA);
                }
            } else if !last {
                IA.eliminate(&pivot, &U, inverse);
            }
            pivots[index] = pivot;
        }
    }
}

/// A DoF's force less its spring's.
#[inline(always)]
fn less_spring<S: Scalar>(model: &Model, freedom: usize, force: S, position: S) -> S {
    if !model.has_springs {
        return force;
    }
    let passive = &model.dofs[freedom].passive;
    force - (position - S::from_f64(passive.rest)).scale(passive.stiffness)
}

impl<S: Scalar> ArticulatedInertia<S> {
    /// Iᴬ a.
    #[inline(always)]
    fn times(&self, a: &Force<S>) -> Force<S> {
        let back = if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back * a.linear
        } else {
            self.coupling.transpose_mul(a.linear)
        };
        Force {
            linear: self.mass * a.linear + self.coupling * a.angular,
            angular: back + self.inertia * a.angular,
        }
    }

    /// The pivot of one DoF's elimination, with U and 1/d.
    #[inline(always)]
    fn pivot(&self, s: &Force<S>, tau: S, armature: S) -> (DofElimination<S>, Force<S>, S) {
        let U = self.times(s);
        let d = s.dot(&U) + armature;
        let u = tau - s.dot(&self.bias);
        let inverse = S::one() / d;
        let scaled = Force { linear: U.linear * inverse, angular: U.angular * inverse };
        (DofElimination { column: scaled, residual: u * inverse, inverse }, U, inverse)
    }

    /// Iᵃ = Iᴬ − U Uᵀ/d, pᵃ = pᴬ + U u/d, in place.
    #[inline(always)]
    fn eliminate(&mut self, pivot: &DofElimination<S>, U: &Force<S>, inverse: S) {
        let ((f, n), (fd, nd)) = ((U.linear, U.angular), (pivot.column.linear, pivot.column.angular));
        self.mass = self.mass.minus_square(f, inverse, fd);
        self.coupling = self.coupling.minus_scaled_outer(f, n, inverse, nd);
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = self.coupling_back.minus_scaled_outer(n, f, inverse, fd);
        }
        self.inertia = self.inertia.minus_square(n, inverse, nd);
        add_scaled(&mut self.bias, pivot.residual, U);
    }

    /// Moves the reference point; d goes from the new point to the old one: H′ = H − M \[d\]×,
    /// I′ = I − Hᵀ\[d\]× + \[d\]× H′.
    #[inline(always)]
    fn shift(&mut self, d: V3<S>) {
        let (cross, mass) = (M3::skew(d), self.mass.full());
        let coupling = self.coupling - mass.times(&cross);
        let inertia = self.inertia.full() - self.coupling.transpose().times(&cross) + cross.times(&coupling);
        self.inertia = Sym3::from_columns(&inertia);
        self.coupling = coupling;
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = coupling.transpose();
        }
        self.bias.angular += d.cross(self.bias.linear);
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.mass = self.mass + other.mass;
        self.coupling = self.coupling + other.coupling;
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = self.coupling_back + other.coupling_back;
        }
        self.inertia = self.inertia + other.inertia;
        self.bias.add(&other.bias);
    }
}

/// The outward pass: q̈ = (u − Uᵀa)/d, and each body's acceleration in `twist_rate`.
#[inline(always)]
pub fn accelerate_freedoms<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let ground = Force { linear: V3::from_f64(model.gravity().map(|g| -g)), angular: V3::zero() };
    let n = model.bodies.len();
    let (bodies, twist_rates) = (&model.bodies[..n], &mut tree.screws.twist_rate[..n]);
    let (pivots, columns, accelerations) =
        (&tree.inertias.pivot[..], &tree.screws.column[..], &mut tree.freedoms.a[..]);
    let levers = &tree.screws.levers[..];
    let mut last = ground;
    for i in 0..n {
        let body = &bodies[i];
        if body.parent == WORLD {
            last = ground;
        } else if body.parent + 1 != i {
            last = twist_rates[body.parent];
        }
        pass_outward(body, levers, &mut last);
        // V̇ = V̇_parent + c + S q̈. Adding c first shortens the chain of dependent operations.
        let mut own = twist_rates[i];
        if M3::<S>::KEEPS_TRANSPOSE {
            own.add(&last);
        }
        for index in body.dof..body.dof + body.motion.nv() {
            let DofElimination { column: U_by_d, residual: u_by_d, .. } = &pivots[index];
            let a = *u_by_d - U_by_d.dot(&last);
            accelerations[index] = a;
            add_scaled(&mut last, a, &columns[index]);
            if M3::<S>::KEEPS_TRANSPOSE {
                add_scaled(&mut own, a, &columns[index]);
            }
        }
        if !M3::<S>::KEEPS_TRANSPOSE {
            own.add(&last);
        }
        twist_rates[i] = own;
        last = own;
    }
}
