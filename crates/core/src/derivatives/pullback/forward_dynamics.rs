//! The acceleration and the pullback of forward dynamics.

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use super::inverse_dynamics::NewtonEulerPullback;
use super::parameters::check_parameters;
use super::sweeps::{Results, sweep_in, weigh_bodies};
use crate::algorithms::forward_dynamics::accelerate_in_world;
use crate::algorithms::forward_dynamics_by_cholesky::accelerate_by_cholesky;
use crate::derivatives::columns::subtract_carried;
use crate::factorization::sparse;
use crate::kinematics::placement::{gather, spread};
use crate::kinematics::shifts::{pass_inward, pass_outward};
use crate::kinematics::wrench::FrameWrench;
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;
use crate::workspace::buffers::DenseBuffers;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{BodyBuffers, DofBuffers, Inertias, TreeMemory, TreeStorage, WorldFrameBuffers};
use crate::{Model, Workspace};

/// The arguments, for trees without coupled branches.
pub struct ArticulatedBodiesPullback<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: &'a [S],
    pub tau: &'a [S],
    pub wrenches: &'a [FrameWrench<S>],
    pub cotangent: &'a [S],
    pub acceleration: &'a mut [S],
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
    pub by_force: &'a mut [S],
    /// The cotangents are added; empty if not requested.
    pub parameters: &'a mut [S],
}

compiled_once!(ArticulatedBodiesPullback);

impl<S: Scalar> Kernel<TreeStorage, S> for ArticulatedBodiesPullback<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, tau, wrenches, cotangent, .. } = self;
        let by_force = N::view_mut(self.by_force);
        spread(model, N::view(tau), &mut tree.dofs.tau);
        accelerate_in_world(model, tree, N::view(q), N::view(v), wrenches);
        gather(model, &tree.dofs.a, N::view_mut(self.acceleration));
        // −ā gives −λ, which has the sign that the pullback of inverse dynamics needs.
        by_force.copy_from_slice(N::view(cotangent));
        negate(by_force);
        spread(model, by_force, &mut tree.dofs.tau);
        solve_again(model, tree);
        by_force.copy_from_slice(&tree.dofs.tau);
        negate(by_force);
        weigh_bodies(model, tree);
        subtract_carried(model, tree, wrenches);
        let mut results = Results {
            by_position: N::view_mut(self.by_position),
            by_velocity: N::view_mut(self.by_velocity),
            by_acceleration: &mut [],
            parameters: N::view_mut(self.parameters),
        };
        sweep_in(model, tree, &mut results);
    }
}

/// Replaces x = `dofs.tau` by M⁻¹ x, by the pivots of [`accelerate_in_world`]; leaves each body's
/// L = Σ S x.
///
/// The sweeps are those of the articulated bodies at rest without gravity: u = τ − sᵀp, p_parent gains p + U
/// u/d; then x = u/d − Uᵀ L/d. **(RBDA §7.3)**
#[inline(always)]
fn solve_again<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let TreeMemory {
        dofs: DofBuffers { tau, .. },
        world: WorldFrameBuffers { column, levers, .. },
        inertias: Inertias { pivot, .. },
        bodies: BodyBuffers { subtree_force: biases, .. },
        pullback,
        ..
    } = tree;
    let (bodies, biases, shadows) = (&model.bodies[..n], &mut biases[..n], &mut pullback.shadow[..n]);
    biases.fill(ForceVector::zero());
    for i in (0..n).rev() {
        let (body, mut bias) = (&bodies[i], biases[i]);
        for k in (body.dof..body.dof + body.motion.nv()).rev() {
            let left = tau[k] - column[k].dot(&bias);
            bias.add_scaled(left, &pivot[k].column);
            tau[k] = left * pivot[k].inverse;
        }
        if body.parent != WORLD {
            pass_inward(body, levers, &mut bias);
            biases[body.parent].add(&bias);
        }
    }
    for i in 0..n {
        let body = &bodies[i];
        let mut shadow = if body.parent == WORLD { MotionVector::zero() } else { shadows[body.parent] };
        pass_outward(body, levers, &mut shadow);
        for k in body.dof..body.dof + body.motion.nv() {
            let x = tau[k] - pivot[k].column.dot(&shadow);
            shadow.add_scaled(x, &column[k]);
            tau[k] = x;
        }
        shadows[i] = shadow;
    }
}

/// The inputs of [`forward_dynamics_pullback_with_parameters`].
#[derive(Clone, Copy, Debug)]
pub struct ForwardPullbackInputs<'a, S> {
    /// The configuration, nq numbers.
    pub q: &'a [S],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [S],
    /// The forces τ, nv numbers \[N·m, N\].
    pub tau: &'a [S],
    /// The wrenches on frames, with components in the frames.
    pub wrenches: &'a [FrameWrench<S>],
    /// The cotangent ā of a, nv numbers.
    pub cotangent: &'a [S],
}

/// The outputs of [`forward_dynamics_pullback`]. Batches have one row per state.
#[derive(Debug)]
pub struct ForwardPullbackMut<'a, S> {
    /// The acceleration a, nv numbers.
    pub acceleration: &'a mut [S],
    /// āᵀ∂a/∂q, nv numbers.
    pub by_position: &'a mut [S],
    /// āᵀ∂a/∂v, nv numbers.
    pub by_velocity: &'a mut [S],
    /// āᵀ∂a/∂τ = (M⁻¹ā)ᵀ, nv numbers.
    pub by_force: &'a mut [S],
    /// The cotangents of the description's parameters, in the layout of
    /// [`ParameterCotangents`](crate::ParameterCotangents), which are added and in batches
    /// overwritten; empty if they are not needed.
    pub parameters: &'a mut [S],
}

/// a = M⁻¹(τ − C v − g) and, for a cotangent ā of a, āᵀ∂a/∂q, āᵀ∂a/∂v and āᵀ∂a/∂τ = (M⁻¹ā)ᵀ, nv numbers each.
/// O(n), without Jacobians and without M⁻¹.
///
/// For a spherical or floating joint, entry j of āᵀ∂a/∂q is the rate along [`integrate`](crate::integrate)(q,
/// δ eⱼ), the directions of v. [`cotangent_to_coordinates`](crate::cotangent_to_coordinates) converts it to
/// the numbers of q. Damping and friction are not included; see
/// [`dissipation_pullback`](crate::dissipation_pullback). If M is singular, the numbers are not finite. A
/// robot with coupled branches uses M and its factor, O(n depth²).
///
/// ```
/// use robot_dynamics::derivatives::{ForwardPullbackMut, forward_dynamics_pullback};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²)
/// let (w, mut a) = (&mut Workspace::<f64>::new(&model), [0.0]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [0.0], [0.0]);
/// let outputs = ForwardPullbackMut {
///     acceleration: &mut a,
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// forward_dynamics_pullback(&model, w, &[0.3], &[1.0], &[0.7], &[3.0], outputs);
/// assert!((a[0] - (0.7 + 9.81 * 0.3_f64.cos()) / 0.5).abs() < 1e-13);
/// assert!((by_q[0] + 3.0 * 9.81 / 0.5 * 0.3_f64.sin()).abs() < 1e-12);
/// assert!(by_v[0].abs() < 1e-13 && (by_tau[0] - 3.0 / (2.0 * 0.25)).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "vector-Jacobian product")]
#[doc(alias = "VJP")]
#[inline]
#[track_caller]
pub fn forward_dynamics_pullback<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    cotangent: &[S],
    results: ForwardPullbackMut<'_, S>,
) {
    forward_dynamics_pullback_with_parameters(
        model,
        workspace,
        ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent },
        results,
    );
}

/// [`forward_dynamics_pullback`] of a = M⁻¹(τ + Σ Jᵀw − C v − g), and the cotangents of the description's
/// parameters. The wrenches w on frames keep their components in their frames.
///
/// `parameters` is empty or has [`parameter_count`](crate::parameter_count) numbers in the layout of
/// [`ParameterCotangents`](crate::ParameterCotangents). The cotangents are **added**, so that calls along a
/// trajectory accumulate. The inertial ones are −λᵀY of the
/// [`joint_torque_regressor`](crate::joint_torque_regressor) with λ = M⁻¹ā. The cotangent of a wrench is J λ:
/// the [`frame_velocity`](crate::frame_velocity) in `ReferenceFrame::Local` at v = λ.
///
/// ```
/// use robot_dynamics::derivatives::ParameterCotangents;
/// use robot_dynamics::derivatives::{ForwardPullbackInputs, ForwardPullbackMut, parameter_count};
/// use robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, mut parameters) = (&mut Workspace::<f64>::new(&model), vec![0.0; parameter_count(&model)]);
/// let [mut a, mut x, mut y, mut z] = [[0.0]; 4];
/// let outputs = ForwardPullbackMut {
///     acceleration: &mut a,
///     by_position: &mut x,
///     by_velocity: &mut y,
///     by_force: &mut z,
///     parameters: &mut parameters,
/// };
/// let inputs =
///     ForwardPullbackInputs { q: &[0.3], v: &[1.0], tau: &[0.7], wrenches: &[], cotangent: &[1.0] };
/// forward_dynamics_pullback_with_parameters(&model, w, inputs, outputs);
/// // a = f/(m l² + armature), so ∂a/∂(armature) = −a/(m l²).
/// let by = ParameterCotangents::of(&model, &parameters);
/// assert!((by.passive[0] + a[0] / 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn forward_dynamics_pullback_with_parameters<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: ForwardPullbackInputs<'_, S>,
    results: ForwardPullbackMut<'_, S>,
) {
    let ForwardPullbackInputs { q, v, tau, wrenches, cotangent } = inputs;
    let ForwardPullbackMut { acceleration, by_position, by_velocity, by_force, parameters } = results;
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the cotangent", cotangent.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    check_length("the cotangent of q", by_position.len(), model.nv);
    check_length("the cotangent of v", by_velocity.len(), model.nv);
    check_length("the cotangent of tau", by_force.len(), model.nv);
    check_parameters(model, parameters);
    if wrenches.is_empty() && parameters.is_empty() {
        let results = &mut [&mut *acceleration, &mut *by_position, &mut *by_velocity, &mut *by_force];
        let (native, function) = (&mut workspace.tree.native, NativeFunction::ForwardDynamicsPullback);
        if computed_natively(model, native, function, &[q, v, tau, cotangent], results) {
            return;
        }
    }
    if model.needs_dense_factor {
        accelerate_by_cholesky(model, workspace, q, v, tau, wrenches, acceleration);
        solve_negative(&workspace.dense, cotangent, by_force);
        let a = &*acceleration;
        run(
            &mut workspace.tree,
            NewtonEulerPullback {
                model,
                q,
                v,
                a,
                wrenches,
                cotangent: by_force,
                by_position,
                by_velocity,
                by_acceleration: &mut [],
                parameters,
            },
        );
        negate(by_force);
        return;
    }
    run(
        &mut workspace.tree,
        ArticulatedBodiesPullback {
            model,
            q,
            v,
            tau,
            wrenches,
            cotangent,
            acceleration,
            by_position,
            by_velocity,
            by_force,
            parameters,
        },
    );
}

/// −M⁻¹ā, by the factor that forward dynamics leaves in the workspace for a robot with coupled branches.
#[inline(always)]
pub fn solve_negative<S: Scalar>(dense: &DenseBuffers<S>, cotangent: &[S], x: &mut [S]) {
    x.copy_from_slice(cotangent);
    negate(x);
    sparse::solve(&dense.dof_parent, &dense.matrix, x);
}

/// x ← −x.
#[inline(always)]
pub fn negate<S: Scalar>(x: &mut [S]) {
    for k in 0..x.len() {
        x[k] = -x[k];
    }
}
