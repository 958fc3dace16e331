//! ∂a/∂q, ∂a/∂v and ∂a/∂τ of forward dynamics a = M⁻¹(τ − C v − g). Cost: O(nv² depth).
//!
//! τ = ID(q, v, a) holds for every a, so ∂a/∂q = −M⁻¹ ∂ID/∂q, ∂a/∂v = −M⁻¹ ∂ID/∂v and ∂a/∂τ = M⁻¹ at the
//! acceleration of the state. Source: Carpentier, Mansard, *Analytical derivatives of rigid body dynamics
//! algorithms*, RSS (2018).
//!
//! Damping and friction are not included. If M is singular, the entries are not finite.

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use super::columns::{accelerate, bend, subtract_carried, sweep_in, sweep_out};
use super::entries::{DerivativeMatrices, write_derivatives, write_mass};
use super::solve_rows::solve_rows;
use crate::factorization::tile::WIDTH;
use crate::kinematics::placement::{gather, spread};
use crate::kinematics::world_frame::compute_columns;
use crate::kinematics::wrench::FrameWrench;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::derivatives::DerivativeBuffers;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// The arguments.
pub struct ForwardDynamicsDerivativesKernel<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: &'a [S],
    pub tau: &'a [S],
    pub wrenches: &'a [FrameWrench<S>],
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
    pub by_force: &'a mut [S],
}

compiled_once!(ForwardDynamicsDerivativesKernel);

impl<S: Scalar> Kernel<TreeStorage, S> for ForwardDynamicsDerivativesKernel<'_, S> {
    const GAINS_BY_AVX512: bool = true;

    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, tau, wrenches, by_position, by_velocity, by_force } = self;
        let (q, v, tau) = (N::view(q), N::view(v), N::view(tau));
        compute_columns(model, tree, q);
        spread(model, v, &mut tree.dofs.v);
        tree.dofs.a.fill(Scalar::zero());
        sweep_out(model, tree, model.gravity().map(|g| -g));
        subtract_carried(model, tree, wrenches);
        sweep_in(model, tree);
        write_mass(model, &mut tree.derivatives);
        tree.derivatives.mass.factor();
        solve_acceleration(model, tree, tau);
        accelerate(model, tree);
        bend(model, tree);
        write_padded_derivatives(model, &mut tree.derivatives);
        let (by_position, by_velocity) = (N::view_mut(by_position), N::view_mut(by_velocity));
        solve_rows::<N, H>(&mut tree.derivatives, by_position, by_velocity, N::view_mut(by_force));
    }
}

/// Writes ∂τ/∂q and ∂τ/∂v to the workspace.
#[inline(always)]
fn write_padded_derivatives<S: Scalar>(model: &Model, scratch: &mut DerivativeBuffers<S>) {
    let DerivativeBuffers { by_position, by_velocity, paths, .. } = scratch;
    if model.needs_dense_factor {
        by_position.fill([S::zero(); WIDTH]);
        by_velocity.fill([S::zero(); WIDTH]);
    }
    let mut derivatives = DerivativeMatrices {
        by_position: by_position.as_flattened_mut(),
        by_velocity: by_velocity.as_flattened_mut(),
        stride: model.nv.next_multiple_of(WIDTH),
    };
    write_derivatives(model, &paths.blocks, &mut derivatives);
}

/// Solves M a = τ − (the forces at a = 0, in `tree.dofs.tau`) and writes a to `tree.dofs.a`.
#[inline(always)]
fn solve_acceleration<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, tau: &[N]) {
    if model.has_springs {
        for (force, dof) in tree.dofs.tau.iter_mut().zip(&model.dofs) {
            let stretch = tree.angles.angle[dof.body] - N::from_f64(dof.passive.rest);
            *force += stretch.scale(dof.passive.stiffness);
        }
    }
    let DerivativeBuffers { mass, vector, .. } = &mut tree.derivatives;
    gather(model, &tree.dofs.tau, vector);
    for (x, &tau) in vector.iter_mut().zip(tau) {
        *x = tau - *x;
    }
    mass.solve(vector);
    spread(model, vector, &mut tree.dofs.a);
}

/// The outputs of [`forward_dynamics_derivatives`]: nv×nv matrices, row-major. Batches have one per state.
#[derive(Debug)]
pub struct ForwardDynamicsDerivativesMut<'a, S> {
    /// ∂a/∂q.
    pub by_position: &'a mut [S],
    /// ∂a/∂v.
    pub by_velocity: &'a mut [S],
    /// ∂a/∂τ.
    pub by_force: &'a mut [S],
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂τ of a = M⁻¹(τ − C v − g), each nv×nv, row-major.
///
/// τ = ID(q, v, a) holds for every a, so at this state's a: ∂a/∂q = −M⁻¹ ∂ID/∂q, ∂a/∂v = −M⁻¹ ∂ID/∂v,
/// ∂a/∂τ = M⁻¹. O(nv² depth). For a spherical or floating joint, column j of ∂a/∂q is the rate along
/// [`integrate`](crate::integrate)(q, δ eⱼ). Damping is not included: subtract M⁻¹ times
/// [`dissipation_derivative`](crate::dissipation_derivative) from ∂a/∂v. If M is singular, the entries are
/// not finite. Source: Carpentier, Mansard, *Analytical derivatives of rigid body dynamics algorithms* (RSS
/// 2018).
///
/// ```
/// use robot_dynamics::derivatives::{ForwardDynamicsDerivativesMut, forward_dynamics_derivatives};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²)
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [0.0], [0.0]);
/// let w = &mut Workspace::<f64>::new(&model);
/// let outputs = ForwardDynamicsDerivativesMut {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
/// };
/// forward_dynamics_derivatives(&model, w, &[0.3], &[1.0], &[0.7], outputs);
/// assert!((by_q[0] + 9.81 / 0.5 * 0.3_f64.sin()).abs() < 1e-13);
/// assert!(by_v[0].abs() < 1e-13 && (by_tau[0] - 1.0 / (2.0 * 0.25)).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "computeABADerivatives")]
#[inline]
#[track_caller]
pub fn forward_dynamics_derivatives<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    derivatives: ForwardDynamicsDerivativesMut<'_, S>,
) {
    forward_dynamics_derivatives_with_wrenches(model, workspace, q, v, tau, &[], derivatives);
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂τ of a = M⁻¹(τ + Σ Jᵀw − C v − g). The wrenches w keep their components in their
/// frames.
///
/// ```
/// use robot_dynamics::algorithms::FrameWrench;
/// use robot_dynamics::derivatives::ForwardDynamicsDerivativesMut;
/// use robot_dynamics::derivatives::forward_dynamics_derivatives_with_wrenches;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // A thruster turns with the rod, so its torque does not depend on the angle; only the weight's does.
/// let (frame, w) = (model.frame_named("tip")?, &mut Workspace::<f64>::new(&model));
/// let thrust = FrameWrench { frame, force_in_frame: [0.0, 0.0, 30.0], moment_in_frame: [0.0; 3] };
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [0.0], [0.0]);
/// let (by_position, by_velocity, by_force) = (&mut by_q, &mut by_v, &mut by_tau);
/// let outputs = ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force };
/// forward_dynamics_derivatives_with_wrenches(&model, w, &[0.3], &[1.0], &[0.7], &[thrust], outputs);
/// assert!((by_q[0] + 9.81 / 0.5 * 0.3_f64.sin()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn forward_dynamics_derivatives_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    derivatives: ForwardDynamicsDerivativesMut<'_, S>,
) {
    let ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force } = derivatives;
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the derivative by q", by_position.len(), model.nv * model.nv);
    check_length("the derivative by v", by_velocity.len(), model.nv * model.nv);
    check_length("the derivative by tau", by_force.len(), model.nv * model.nv);
    workspace.allocate_matrices(model);
    run(
        &mut workspace.tree,
        ForwardDynamicsDerivativesKernel { model, q, v, tau, wrenches, by_position, by_velocity, by_force },
    );
}
