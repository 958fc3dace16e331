//! The derivatives A and B of one step of each state of a batch.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::{Integrator, StepScheme};
use robot_dynamics_number::check_positive;
use robot_dynamics_simulation::{
    LinearizeStepWorkspace, LinearizedStep, RobotState, StepForces, StepWorkspace, Stepper,
};

use crate::BatchWorkspace;
use crate::bad_states::BadStateSet;
use crate::distribution::for_each_state;
use crate::rollout::RolloutError;
use crate::tables::check_table;

/// The inputs of [`linearize_step`] and [`linearize_stepper`].
#[derive(Clone, Copy, Debug)]
pub struct LinearizeInputs<'a> {
    /// The step \[s\].
    pub step: f64,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// Configurations, \[batch\]\[nq\].
    pub q: &'a [f64],
    /// Velocities, \[batch\]\[nv\].
    pub v: &'a [f64],
    /// Forces, \[batch\]\[nv\]; empty for none.
    pub tau: &'a [f64],
}

/// A and B of one step of each state by an explicit row: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ.
///
/// `by_state` is \[batch\]\[2nv\]\[2nv\], `by_force` is \[batch\]\[2nv\]\[nv\]. They are the numbers of
/// [`linearize_step`](robot_dynamics_simulation::linearize_step), bit for bit, for any number of threads. Each
/// thread computes one state at a time, and allocates its memory once in a call.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, LinearizeInputs, linearize_step};
/// use robot_dynamics::derivatives::LinearizedStep;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, h) = (&BatchWorkspace::new(&model), 0.01);
/// let inputs = LinearizeInputs { step: h, dissipation: false, q: &[0.0, 0.3], v: &[0.0; 2], tau: &[] };
/// let (mut a, mut b) = ([0.0; 8], [0.0; 4]);
/// let results = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// linearize_step(&model, workspace, Integrator::ExplicitEuler, inputs, results)?;
/// // v₁ = v₀ + h (τ + m g l cos q)/(m l²), so ∂v₁/∂q₀ = −h g/l sin q.
/// assert!((a[6] + h * 9.81 / 0.5 * 0.3_f64.sin()).abs() < 1e-14);
/// assert!((b[3] - h / (2.0 * 0.25)).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError::BadStates`] lists the states without a valid result, including those with a singular M;
/// their matrices are NaN and all others are valid. Other errors name an invalid step and an implicit row.
///
/// # Panics
/// If a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn linearize_step(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    integrator: Integrator,
    inputs: LinearizeInputs<'_>,
    results: LinearizedStep<'_>,
) -> Result<(), RolloutError> {
    if !matches!(integrator.scheme(), StepScheme::Explicit(_)) {
        return Err(RolloutError::Implicit { integrator });
    }
    let memory = || LinearizeStepWorkspace::new(model);
    linearize_each(model, workspace, inputs, results, &memory, &|memory, forces, state, out| {
        robot_dynamics_simulation::linearize_step(model, integrator, memory, forces, inputs.step, state, out)
            .is_ok()
    })
}

/// A and B of one step of each state by any [`Stepper`], through contact, stops and friction.
///
/// Shapes are those of [`linearize_step`]. The derivatives are those of
/// [`linearize_stepper`](robot_dynamics_simulation::linearize_stepper). For each state a copy of the stepper
/// first takes a step from it, so its contacts are those that this step finds.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, LinearizeInputs, linearize_stepper};
/// use robot_dynamics::derivatives::LinearizedStep;
/// use robot_dynamics::description::{Limits, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::ImplicitIntegrator;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].limits = Limits::new(-0.2, 0.0);
/// let model = Model::new(robot)?;
/// let (workspace, stepper) = (&BatchWorkspace::new(&model), &ImplicitIntegrator::new(&model));
/// // The first pendulum is pushed against its stop, which takes up any force; the second one moves.
/// let tau = &[2.0 * 9.81 * 0.5 + 3.0, 0.0];
/// let inputs = LinearizeInputs { step: 1e-3, dissipation: true, q: &[0.0, -0.1], v: &[0.0; 2], tau };
/// let (mut a, mut b) = ([0.0; 8], [0.0; 4]);
/// let results = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// linearize_stepper(&model, workspace, stepper, inputs, results)?;
/// assert!(b[1].abs() < 1e-9 && (b[3] - 1e-3 / (2.0 * 0.25)).abs() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`linearize_step`]. A state with a step nearby that fails or is discontinuous has no valid result.
///
/// # Panics
/// If a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn linearize_stepper<S: Stepper + Clone + Sync>(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    stepper: &S,
    inputs: LinearizeInputs<'_>,
    results: LinearizedStep<'_>,
) -> Result<(), RolloutError> {
    let memory = || (StepWorkspace::new(model), vec![0.0; model.nq()], vec![0.0; model.nv()]);
    linearize_each(model, workspace, inputs, results, &memory, &|memory, forces, state, out| {
        let ((workspace, q, v), h, mut stepper) = (memory, inputs.step, stepper.clone());
        q.copy_from_slice(state.q);
        v.copy_from_slice(state.v);
        stepper.step(model, workspace, forces, h, q, v).is_ok()
            && robot_dynamics_simulation::linearize_stepper(
                model,
                &mut stepper,
                workspace,
                forces,
                h,
                state,
                out,
            )
            .is_ok()
    })
}

/// Calls `linearize` for each state; writes NaN where it returns false.
#[track_caller]
fn linearize_each<M>(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    inputs: LinearizeInputs<'_>,
    results: LinearizedStep<'_>,
    memory: &(impl Fn() -> M + Sync),
    linearize: &(impl Fn(&mut M, &StepForces<'_>, RobotState<'_>, LinearizedStep<'_>) -> bool + Sync),
) -> Result<(), RolloutError> {
    workspace.check(model);
    let LinearizeInputs { step, dissipation, q, v, tau } = inputs;
    let (nq, nv) = (model.nq(), model.nv());
    check_positive("the step", step, "s")?;
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    if !tau.is_empty() {
        check_table("tau", tau.len(), batch, nv);
    }
    let LinearizedStep { by_state, by_force } = results;
    check_table("A", by_state.len(), batch, 4 * nv * nv);
    check_table("B", by_force.len(), batch, 2 * nv * nv);
    let (bad, zeros) = (BadStateSet::default(), vec![0.0; nv]);
    for_each_state(workspace, batch, [by_state, by_force], memory, &|memory, state, [by_state, by_force]| {
        let row = state * nv..(state + 1) * nv;
        let tau = if tau.is_empty() { &zeros[..] } else { &tau[row.clone()] };
        let forces = StepForces::new(tau, dissipation);
        let at = RobotState { q: &q[state * nq..(state + 1) * nq], v: &v[row] };
        let is_finite = at.q.iter().chain(at.v).chain(tau).all(|x| x.is_finite());
        let out = LinearizedStep { by_state: &mut *by_state, by_force: &mut *by_force };
        if !is_finite || !linearize(memory, &forces, at, out) {
            by_state.fill(f64::NAN);
            by_force.fill(f64::NAN);
            bad.add(1, state);
        }
    });
    Ok(bad.into_result(batch)?)
}
