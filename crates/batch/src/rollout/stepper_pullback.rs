//! The pullback of rollouts of batches by any stepper, state by state.

use std::sync::{Mutex, PoisonError};

use robot_dynamics_core::Model;
use robot_dynamics_number::check_positive;
use robot_dynamics_simulation::motion::pullback::checkpoints::RolloutInputs;
use robot_dynamics_simulation::motion::pullback::stepper_checkpoints::pull_back_by_stepper;
use robot_dynamics_simulation::{
    LinearizedSteps, MotionCotangents, RobotState, Stepper, StepperPullbackWorkspace, StepperRollout,
};

use super::error::RolloutError;
use super::outcome::StateOutcomes;
use super::progress::{RolloutObserver, SharedProgress, UNOBSERVED};
use super::pullback::RolloutPullbackInputs;
use super::torques::Torques;
use crate::BatchWorkspace;
use crate::distribution::for_each_state;
use crate::tables::check_table;

/// [`rollout_pullback`](super::rollout_pullback) by any [`Stepper`], with contact, stops and dry friction; see
/// [`rollout_pullback_by_stepper`](robot_dynamics_simulation::rollout_pullback_by_stepper).
///
/// Shapes, progress and cancellation are those of [`rollout_pullback`](super::rollout_pullback), without
/// parameters. The numbers are those of single states, bit for bit, for any number of threads. Each thread
/// computes one state at a time, and allocates its memory once in a call. The result counts the steps of all
/// states by the method of their derivatives.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, RolloutPullbackInputs, StepperRollout, Torques};
/// use robot_dynamics::batch::rollout_pullback_by_stepper;
/// use robot_dynamics::derivatives::{MotionCotangents, TrajectoryCotangents};
/// use robot_dynamics::description::{Limits, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::ImplicitIntegrator;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].limits = Limits::new(-0.2, 0.0);
/// let (model, h) = (Model::new(robot)?, 1e-3);
/// // The first pendulum is pushed against its stop, which takes up any force; the second one moves.
/// let (q, tau) = ([0.0, -0.1], [2.0 * 9.81 * 0.5 + 3.0, 0.0]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0; 2], [1.0; 2], [0.0; 2]);
/// let stepper = ImplicitIntegrator::new(&model);
/// let (rollout, trajectory) = (StepperRollout::new(&stepper, h, 10), TrajectoryCotangents::default());
/// let torques = Torques::Held(&tau);
/// let inputs = RolloutPullbackInputs { spacing: 0, torques, q: &q, v: &[0.0; 2], trajectory };
/// let cotangents = MotionCotangents {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// let workspace = &BatchWorkspace::new(&model);
/// rollout_pullback_by_stepper(&model, workspace, &rollout, &inputs, cotangents, None)?;
/// assert!(by_tau[0].abs() < 1e-12 && (by_tau[1] - 10.0 * h / (2.0 * 0.25)).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid. A state with a step that fails, or whose
/// step is discontinuous, is a bad state. [`RolloutError::Policy`] if a policy gives the torques.
///
/// # Panics
/// If a table has the wrong length, the workspace belongs to another model, or `parameters` is not empty.
#[track_caller]
pub fn rollout_pullback_by_stepper<S: Stepper + Clone + Sync>(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    rollout: &StepperRollout<'_, S>,
    inputs: &RolloutPullbackInputs<'_, f64>,
    cotangents: MotionCotangents<'_, f64>,
    progress: Option<RolloutObserver<'_>>,
) -> Result<LinearizedSteps, RolloutError> {
    let MotionCotangents { by_position, by_velocity, by_force, parameters } = cotangents;
    let RolloutPullbackInputs { torques, q, v, trajectory, spacing } = *inputs;
    workspace.check(model);
    check_positive("the step", rollout.step, "s")?;
    let (nq, nv, steps) = (model.nq(), model.nv(), rollout.steps);
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    let samples = rollout.samples() * nv;
    check_table("v", v.len(), batch, nv);
    check_table("the cotangent of the trajectory's q", trajectory.by_position.len(), batch, samples);
    check_table("the cotangent of the trajectory's v", trajectory.by_velocity.len(), batch, samples);
    torques.check(batch, steps, nv);
    let force_width = match torques {
        Torques::Zero => 0,
        Torques::Held(_) => nv,
        Torques::EachStep(_) => steps * nv,
        Torques::Policy(_) => return Err(RolloutError::Policy),
    };
    check_table("the cotangent of q", by_position.len(), batch, nv);
    check_table("the cotangent of v", by_velocity.len(), batch, nv);
    check_table("the cotangent of tau", by_force.len(), batch, force_width);
    check_table("the parameters", parameters.len(), batch, 0);
    let shared = SharedProgress::new(progress.unwrap_or(UNOBSERVED), batch as u64 * steps as u64);
    let (outcome, sum) = (StateOutcomes::default(), Mutex::new(Vec::new()));
    let memory = || StateMemory {
        workspace: StepperPullbackWorkspace::new(model, spacing),
        cotangents: [vec![0.0; nv], vec![0.0; nv]],
    };
    let tables = [by_position, by_velocity, by_force];
    for_each_state(workspace, batch, tables, &memory, &|memory: &mut StateMemory<S>, state, results| {
        let pulled = if shared.is_cancelled() {
            Pulled::Cancelled
        } else {
            memory.pull_back(model, rollout, (inputs, state), results, &shared)
        };
        if let Pulled::Back(counts) = pulled {
            sum.lock().unwrap_or_else(PoisonError::into_inner).push((state, counts));
        }
        outcome.add(u32::from(pulled == Pulled::Failed), pulled != Pulled::Cancelled, state..state + 1);
    });
    outcome.into_result(batch)?;
    // In the order of the states, so that the first reason does not depend on the threads.
    let mut each = sum.into_inner().unwrap_or_else(PoisonError::into_inner);
    each.sort_unstable_by_key(|(state, _)| *state);
    let mut counts = LinearizedSteps::default();
    for (_, own) in &each {
        counts.add(own);
    }
    Ok(counts)
}

/// The result of one state.
#[derive(Clone, Copy, PartialEq)]
enum Pulled {
    Back(LinearizedSteps),
    Cancelled,
    Failed,
}

/// The memory of a thread.
struct StateMemory<S> {
    workspace: StepperPullbackWorkspace<S>,
    /// The gradients by q and v.
    cotangents: [Vec<f64>; 2],
}

impl<S: Stepper + Clone> StateMemory<S> {
    /// Pulls one state back.
    fn pull_back(
        &mut self,
        model: &Model,
        rollout: &StepperRollout<'_, S>,
        (inputs, state): (&RolloutPullbackInputs<'_, f64>, usize),
        [by_position, by_velocity, by_force]: [&mut [f64]; 3],
        shared: &SharedProgress<'_>,
    ) -> Pulled {
        let Self { workspace, cotangents: [by_q, by_v] } = self;
        let (nq, nv) = (model.nq(), model.nv());
        let at = RobotState {
            q: &inputs.q[state * nq..(state + 1) * nq],
            v: &inputs.v[state * nv..(state + 1) * nv],
        };
        by_q.copy_from_slice(by_position);
        by_v.copy_from_slice(by_velocity);
        by_force.fill(0.0);
        let is_finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        let starts = is_finite(at.q) && is_finite(at.v);
        let mut course = OneState { rollout, inputs, state, by_force: &mut *by_force, shared };
        let way = (rollout, rollout.spacing(inputs.spacing));
        let mut pulled = Pulled::Failed;
        if starts {
            pulled = match pull_back_by_stepper(model, way, &mut course, workspace, at, (by_q, by_v)) {
                Ok(Some(counts)) => Pulled::Back(counts),
                Ok(None) => return Pulled::Cancelled,
                Err(_) => Pulled::Failed,
            };
        }
        if !(is_finite(by_q) && is_finite(by_v) && is_finite(by_force)) {
            pulled = Pulled::Failed;
        }
        if pulled == Pulled::Failed {
            by_q.fill(f64::NAN);
            by_v.fill(f64::NAN);
            by_force.fill(f64::NAN);
        }
        by_position.copy_from_slice(by_q);
        by_velocity.copy_from_slice(by_v);
        pulled
    }
}

/// The forces and cotangents of one state.
struct OneState<'a, S> {
    rollout: &'a StepperRollout<'a, S>,
    inputs: &'a RolloutPullbackInputs<'a, f64>,
    state: usize,
    by_force: &'a mut [f64],
    shared: &'a SharedProgress<'a>,
}

impl<S> RolloutInputs<f64> for OneState<'_, S> {
    fn torque(&mut self, step: usize, tau: &mut [f64]) {
        let (rollout, still) = (self.rollout, (&[][..], &[][..]));
        tau.fill(0.0);
        self.inputs.torques.at(self.state, (step, rollout.steps), rollout.step, still, tau);
    }

    fn add_cotangents(&mut self, sample: usize, by_position: &mut [f64], by_velocity: &mut [f64]) {
        let (nv, row) = (by_position.len(), self.state * self.rollout.samples() + sample);
        let trajectory = &self.inputs.trajectory;
        let add = |sum: &mut [f64], table: &[f64]| {
            sum.iter_mut().zip(&table[row * nv..(row + 1) * nv]).for_each(|(sum, x)| *sum += x);
        };
        add(by_position, trajectory.by_position);
        add(by_velocity, trajectory.by_velocity);
    }

    fn record(&mut self, step: usize, by_force: &[f64]) {
        let nv = by_force.len();
        match self.inputs.torques {
            Torques::Zero | Torques::Policy(_) => {}
            Torques::Held(_) => self.by_force.iter_mut().zip(by_force).for_each(|(sum, x)| *sum += x),
            Torques::EachStep(_) => self.by_force[step * nv..(step + 1) * nv].copy_from_slice(by_force),
        }
    }

    fn go_on(&mut self, steps: usize) -> bool {
        self.shared.go_on(steps as u64)
    }
}
