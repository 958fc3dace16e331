//! Forward dynamics by the articulated-body algorithm, O(n).
//!
//! The inward pass finds each body's articulated inertia Iᴬ and bias force pᴬ. The force F = Iᴬ a + pᴬ gives
//! the body the acceleration a while all joints beyond it are free. Eliminating one DoF s leaves
//! Iᵃ = Iᴬ − U Uᵀ/d and pᵃ = pᴬ + U u/d, with U = Iᴬ s, d = sᵀU + armature and u = τ − sᵀpᴬ.
//!
//! The outward pass solves q̈ = (u − Uᵀa)/d. **(RBDA §7.3)** The code uses the same letters. `IA` holds pᴬ as
//! `bias`, and a [`DofElimination`](crate::spatial::inertia::DofElimination) holds U/d and u/d.
//!
//! A joint of several DoFs is eliminated one DoF at a time. There are two forms. `world_frame` uses one
//! inertial frame, so that inertias add without a rotation. `body_frames` takes fewer operations where
//! expressions are traced, as zeros and ones fold there.

mod articulated_inertia;
mod body_frames;
mod pivots;
mod spring;
mod world_frame;

#[doc(hidden)]
pub use pivots::inverse_pivots;
pub(crate) use world_frame::accelerate as accelerate_in_world;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::algorithms::forward_dynamics_by_cholesky::accelerate_by_cholesky;
use crate::kinematics::placement::{gather, spread};
use crate::kinematics::wrench::FrameWrench;
use crate::model::native::NativeFunction;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
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

compiled_once!(ArticulatedBodies);

impl<S: Scalar> Kernel<TreeStorage, S> for ArticulatedBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, tau, wrenches, acceleration } = self;
        let (q, v, tau, acceleration) = (N::view(q), N::view(v), N::view(tau), N::view_mut(acceleration));
        spread(model, tau, &mut tree.dofs.tau);
        if M3::<N>::FOLDS_ZEROS {
            body_frames::accelerate(model, tree, q, v, wrenches);
        } else {
            world_frame::accelerate(model, tree, q, v, wrenches);
        }
        gather(model, &tree.dofs.a, acceleration);
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
