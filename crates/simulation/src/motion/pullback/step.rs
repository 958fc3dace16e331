//! The pullback of one step of one state.

use robot_dynamics_core::derivatives::check_parameters;
use robot_dynamics_core::workspace::native::computed_natively;
use robot_dynamics_core::{
    ForwardPullbackInputs, ForwardPullbackMut, Model, NativeFunction, Workspace, forward_dynamics,
    forward_dynamics_pullback_with_parameters, parameter_count,
};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{Integrator, StepScheme};
use robot_dynamics_number::Scalar;

use super::checks::{check_floats, check_given, check_mass};
use super::cotangents::MotionCotangents;
use super::stages::{
    Accelerations, Cotangents, PullbackMemory, PullbackPoint, PullbackTree, add, pull_back_step,
};
use crate::StepForces;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::motion::integrate::stage_memory::most_stages;
use crate::motion::simulate::StepError;

/// Scratch for [`step_pullback`] on one model.
#[derive(Clone, Debug)]
pub struct StepPullbackWorkspace<S: Scalar = f64> {
    dynamics: Workspace<S>,
    stages: Vec<S>,
    force: Vec<S>,
    acceleration: Vec<S>,
    by_stage_force: Vec<S>,
    by_force: Vec<S>,
    by_position: Vec<S>,
    by_velocity: Vec<S>,
    cotangent: Vec<S>,
    parameters: Vec<S>,
}

impl<S: Scalar> StepPullbackWorkspace<S> {
    /// Allocates the memory for this model; nothing else allocates.
    pub fn new(model: &Model) -> Self {
        let vector = || vec![S::zero(); model.nv];
        Self {
            dynamics: Workspace::new(model),
            stages: vec![S::zero(); PullbackMemory::<S>::size(model, most_stages())],
            force: vector(),
            acceleration: vector(),
            by_stage_force: vector(),
            by_force: vector(),
            by_position: vector(),
            by_velocity: vector(),
            cotangent: vec![S::zero(); 2 * model.nv],
            parameters: vec![S::zero(); parameter_count(model)],
        }
    }
}

/// Forward dynamics of one state, and the pullback of its steps by machine code.
pub(super) struct OneState<'a, S: Scalar> {
    pub workspace: &'a mut Workspace<S>,
    /// The pullback of a step, if machine code may compute it.
    pub pullback: Option<NativeFunction>,
    /// 2 nv numbers.
    pub cotangent: &'a mut [S],
}

impl<S: Scalar> Accelerations<S> for OneState<'_, S> {
    fn accelerate(&mut self, model: &Model, q: &[S], v: &[S], tau: &[S], a: &mut [S]) {
        forward_dynamics(model, self.workspace, q, v, tau, a);
    }

    fn pull_back_natively(
        &mut self,
        model: &Model,
        [q, v, tau]: [&[S]; 3],
        h: S,
        (by_q, by_v): (&mut [S], &mut [S]),
        by_force: &mut [S],
    ) -> bool {
        let Some(function) = self.pullback else { return false };
        let (of_q, of_v) = self.cotangent.split_at_mut(model.nv);
        of_q.copy_from_slice(by_q);
        of_v.copy_from_slice(by_v);
        let native = &mut self.workspace.tree.native;
        let arguments = &[q, v, tau, &[h], &*self.cotangent];
        let is_computed =
            computed_natively(model, native, function, arguments, &mut [&mut *by_q, &mut *by_v, by_force]);
        if !is_computed {
            let (of_q, of_v) = self.cotangent.split_at(model.nv);
            by_q.copy_from_slice(of_q);
            by_v.copy_from_slice(of_v);
        }
        is_computed
    }

    fn pull_back(&mut self, model: &Model, at: PullbackPoint<'_, S>, to: Cotangents<'_, S>) {
        let PullbackPoint { q, v, tau, cotangent } = at;
        let Cotangents { acceleration, by_position, by_velocity, by_force, parameters } = to;
        let out = ForwardPullbackMut { acceleration, by_position, by_velocity, by_force, parameters };
        forward_dynamics_pullback_with_parameters(
            model,
            self.workspace,
            ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent },
            out,
        );
    }
}

/// Maps the cotangents of the end of one [`step`](crate::step) to those of its start, its force and the
/// parameters:
///
/// > (q̄₀, v̄₀) = Aᵀ (q̄₁, v̄₁),  τ̄ = Bᵀ (q̄₁, v̄₁)
///
/// A and B are those of [`linearize_step`](crate::linearize_step), and are not formed. The cost is about
/// three times that of the step for any nv. It does not allocate.
///
/// `by_position` and `by_velocity` hold (q̄₁, v̄₁) and receive (q̄₀, v̄₀); `by_force` is written. Cotangents
/// of configurations have nv numbers, along the displacements of [`integrate`](robot_dynamics_core::integrate()) at q₁ and
/// at q₀: see [`cotangent_to_coordinates`](robot_dynamics_core::cotangent_to_coordinates). `parameters` is
/// empty or has the layout of [`ParameterCotangents`](robot_dynamics_core::ParameterCotangents); the
/// cotangents are **added** to it. Damping follows v, and the sign of the friction is held constant. Over
/// dual numbers the function gives second derivatives of a step. On an error all results are unchanged.
///
/// ```
/// use robot_dynamics::derivatives::{LinearizedStep, MotionCotangents, RobotState, StepPullbackWorkspace};
/// use robot_dynamics::derivatives::{linearize_step, step_pullback};
/// use robot_dynamics::simulation::{Integrator, StepForces};
/// # use robot_dynamics::derivatives::LinearizeStepWorkspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a: weights, tau, .. } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (n, h, row) = (model.nv(), 1e-3, Integrator::RungeKutta4);
/// let forces = StepForces::new(&tau, true);
/// let (mut by_q, mut by_v, mut by_tau) = (weights.clone(), vec![0.0; n], vec![0.0; n]); // the loss is weights · q₁
/// let w = &mut StepPullbackWorkspace::new(&model);
/// let state = RobotState { q: &q, v: &v };
/// let derivatives = MotionCotangents {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// step_pullback(&model, row, w, &forces, h, state, derivatives)?;
/// let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
/// let state = RobotState { q: &q, v: &v };
/// let derivatives = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// linearize_step(&model, row, &mut LinearizeStepWorkspace::new(&model), &forces, h, state, derivatives)?;
/// for j in 0..n {
///     let column: f64 = (0..n).map(|i| weights[i] * a[i * 2 * n + j]).sum();
///     assert!((by_q[j] - column).abs() < 1e-11);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`StepError`] if a given or computed float is not finite, if `h` is not positive, or if
///   M(q) is singular, with the names of the joints (checked in advance for `f64`).
/// - [`StepError::NotDifferentiable`] for the variational rows.
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn step_pullback<S: Scalar>(
    model: &Model,
    integrator: Integrator,
    workspace: &mut StepPullbackWorkspace<S>,
    forces: &StepForces<'_, S>,
    h: f64,
    RobotState { q, v }: RobotState<'_, S>,
    cotangents: MotionCotangents<'_, S>,
) -> Result<(), StepError> {
    let MotionCotangents { by_position, by_velocity, by_force, parameters } = cotangents;
    check_step(h)?;
    workspace.dynamics.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", forces.tau.len(), model.nv);
    check_length("the cotangent of q", by_position.len(), model.nv);
    check_length("the cotangent of v", by_velocity.len(), model.nv);
    check_length("the cotangent of tau", by_force.len(), model.nv);
    check_parameters(model, parameters);
    let StepScheme::Explicit(stages) = integrator.scheme() else {
        return Err(StepError::NotDifferentiable { integrator });
    };
    let given = [("q", q), ("v", v), ("tau", forces.tau)];
    let cotangents = [("the cotangent of q", &*by_position), ("the cotangent of v", &*by_velocity)];
    for (quantity, numbers) in given.into_iter().chain(cotangents) {
        check_given(quantity, numbers)?;
    }
    check_mass(model, &mut workspace.dynamics, q)?;
    let w = workspace;
    w.by_position.copy_from_slice(by_position);
    w.by_velocity.copy_from_slice(by_velocity);
    w.parameters.fill(S::zero());
    let own_parameters = &mut w.parameters[..parameters.len()];
    let pullback = NativeFunction::step_pullback(integrator, forces.dissipation);
    let accelerations = &mut OneState { workspace: &mut w.dynamics, pullback, cotangent: &mut w.cotangent };
    let (cotangents, at) = ((&mut w.by_position[..], &mut w.by_velocity[..]), [q, v, forces.tau]);
    let is_computed = parameters.is_empty()
        && accelerations.pull_back_natively(model, at, S::from_f64(h), cotangents, &mut w.by_force);
    if !is_computed {
        w.by_force.fill(S::zero());
        let mut motion = PullbackTree {
            model,
            accelerations,
            dissipation: forces.dissipation,
            tau: forces.tau,
            force: &mut w.force,
            acceleration: &mut w.acceleration,
            by_stage_force: &mut w.by_stage_force,
            by_force: &mut w.by_force,
            parameters: own_parameters,
        };
        let mut memory = PullbackMemory::new(model, stages.len(), &mut w.stages);
        let cotangents = (&mut w.by_position[..], &mut w.by_velocity[..]);
        pull_back_step(model, stages, &mut motion, S::from_f64(h), &mut memory, (q, v, &[]), cotangents);
    }
    for (quantity, numbers) in [
        ("the cotangent of q at the start", &w.by_position[..]),
        ("the cotangent of v at the start", &w.by_velocity),
        ("the cotangent of tau", &w.by_force),
        ("the cotangent of a parameter", &w.parameters),
    ] {
        check_floats(quantity, numbers)?;
    }
    by_position.copy_from_slice(&w.by_position);
    by_velocity.copy_from_slice(&w.by_velocity);
    by_force.copy_from_slice(&w.by_force);
    add(parameters, &w.parameters[..parameters.len()]);
    Ok(())
}
