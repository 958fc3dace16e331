//! The pullback of a rollout by a stepper with checkpoints, from the last step to the first.

use robot_dynamics_core::Model;

use super::checkpoints::RolloutInputs;
use super::stepper_rollout::StepperRollout;
use crate::motion::RobotState;
use crate::motion::linearize_step::linearize_stepper;
use crate::motion::linearize_step::results::{LinearizedStep, LinearizedSteps};
use crate::motion::simulate::StepError;
use crate::{StepForces, StepWorkspace, Stepper};

/// A state of the rollout with the stepper that continues from it.
#[derive(Clone, Debug)]
struct Checkpoint<S> {
    q: Vec<f64>,
    v: Vec<f64>,
    stepper: S,
}

impl<S: Clone> Checkpoint<S> {
    fn new((q, v): (&[f64], &[f64]), stepper: &S) -> Self {
        Self { q: q.to_vec(), v: v.to_vec(), stepper: stepper.clone() }
    }

    /// In place, to keep the memory of the stepper.
    fn copy_from(&mut self, other: &Self) {
        self.q.copy_from_slice(&other.q);
        self.v.copy_from_slice(&other.v);
        self.stepper.clone_from(&other.stepper);
    }
}

/// Scratch for [`rollout_pullback_by_stepper`](crate::rollout_pullback_by_stepper).
#[derive(Debug)]
pub struct StepperPullbackWorkspace<S> {
    step: StepWorkspace,
    /// The requested number of steps between checkpoints.
    pub(super) spacing: usize,
    /// The states at every `spacing`-th step, and those between two checkpoints.
    checkpoints: Vec<Checkpoint<S>>,
    segment: Vec<Checkpoint<S>>,
    tau: Vec<f64>,
    by_state: Vec<f64>,
    by_force: Vec<f64>,
    cotangent: Vec<f64>,
    force_cotangent: Vec<f64>,
}

impl<S> StepperPullbackWorkspace<S> {
    /// The workspace for this model, with a checkpoint at every `spacing`-th step; 0 selects √steps, which is
    /// near the minimum of memory. A checkpoint holds a state and a copy of the stepper. The checkpoints are
    /// allocated at the first rollout, and kept.
    pub fn new(model: &Model, spacing: usize) -> Self {
        let nv = model.nv;
        Self {
            step: StepWorkspace::new(model),
            spacing,
            checkpoints: Vec::new(),
            segment: Vec::new(),
            tau: vec![0.0; nv],
            by_state: vec![0.0; 4 * nv * nv],
            by_force: vec![0.0; 2 * nv * nv],
            cotangent: vec![0.0; 2 * nv],
            force_cotangent: vec![0.0; nv],
        }
    }
}

/// Copies a checkpoint to the entry at `index` of a list, which it extends by at most one.
fn store<S: Clone>(list: &mut Vec<Checkpoint<S>>, index: usize, checkpoint: &Checkpoint<S>) {
    match list.get_mut(index) {
        Some(own) => own.copy_from(checkpoint),
        None => list.push(checkpoint.clone()),
    }
}

/// Pulls the cotangents (q̄, v̄) at the end of a rollout back to its start, in place. Returns how the steps
/// were differentiated, or `None` if the rollout was cancelled.
pub fn pull_back_by_stepper<S: Stepper + Clone, C: RolloutInputs<f64>>(
    model: &Model,
    (rollout, spacing): (&StepperRollout<'_, S>, usize),
    course: &mut C,
    workspace: &mut StepperPullbackWorkspace<S>,
    state: RobotState<'_>,
    (by_q, by_v): (&mut [f64], &mut [f64]),
) -> Result<Option<LinearizedSteps>, StepError> {
    let mut counts = LinearizedSteps::default();
    let steps = rollout.steps;
    let mut current = Checkpoint::new((state.q, state.v), rollout.stepper);
    current.stepper.check_start(model, workspace.step.dynamics(), rollout.step, state.q, state.v)?;
    // Forward: the first state of each segment.
    let segments = steps.div_ceil(spacing);
    for segment in 0..segments {
        store(&mut workspace.checkpoints, segment, &current);
        if segment + 1 < segments {
            for step in segment * spacing..(segment + 1) * spacing {
                workspace.advance(model, rollout, course, (&mut current, step))?;
            }
        }
    }
    for segment in (0..segments).rev() {
        let first = segment * spacing;
        let count = spacing.min(steps - first);
        current.copy_from(&workspace.checkpoints[segment]);
        for k in 0..count {
            store(&mut workspace.segment, k, &current);
            if k + 1 < count {
                workspace.advance(model, rollout, course, (&mut current, first + k))?;
            }
        }
        for k in (0..count).rev() {
            let done = first + k + 1;
            if rollout.stride != 0 && done.is_multiple_of(rollout.stride) {
                course.add_cotangents(done / rollout.stride - 1, by_q, by_v);
            }
            workspace.step_back(model, rollout, course, (k, first + k), (by_q, by_v), &mut counts)?;
        }
        if !course.go_on(count) {
            return Ok(None);
        }
    }
    Ok(Some(counts))
}

impl<S: Stepper + Clone> StepperPullbackWorkspace<S> {
    /// Takes one step in place.
    fn advance<C: RolloutInputs<f64>>(
        &mut self,
        model: &Model,
        rollout: &StepperRollout<'_, S>,
        course: &mut C,
        (at, step): (&mut Checkpoint<S>, usize),
    ) -> Result<(), StepError> {
        let Checkpoint { q, v, stepper } = at;
        restart(rollout, stepper);
        course.torque(step, &mut self.tau);
        stepper.check_mass(model, self.step.dynamics(), q)?;
        let forces = StepForces::new(&self.tau, rollout.dissipation);
        stepper.step(model, &mut self.step, &forces, rollout.step, q, v)
    }

    /// Multiplies the cotangents by Aᵀ and Bᵀ of the step from the segment's k-th state.
    fn step_back<C: RolloutInputs<f64>>(
        &mut self,
        model: &Model,
        rollout: &StepperRollout<'_, S>,
        course: &mut C,
        (k, step): (usize, usize),
        (by_q, by_v): (&mut [f64], &mut [f64]),
        counts: &mut LinearizedSteps,
    ) -> Result<(), StepError> {
        let Self { step: memory, segment, tau, by_state, by_force, cotangent, force_cotangent, .. } = self;
        let Checkpoint { q, v, stepper } = &mut segment[k];
        restart(rollout, stepper);
        course.torque(step, tau);
        stepper.check_mass(model, memory.dynamics(), q)?;
        let forces = StepForces::new(tau, rollout.dissipation);
        let out = LinearizedStep { by_state, by_force };
        let method =
            linearize_stepper(model, stepper, memory, &forces, rollout.step, RobotState { q, v }, out)?;
        counts.count(&method);
        let nv = by_v.len();
        cotangent[..nv].copy_from_slice(by_q);
        cotangent[nv..].copy_from_slice(by_v);
        multiply_transposed(by_force, cotangent, &mut [force_cotangent]);
        multiply_transposed(by_state, cotangent, &mut [by_q, by_v]);
        course.record(step, force_cotangent);
        Ok(())
    }
}

/// Forgets the forces of the step before, if each step of the rollout restarts.
fn restart<S: Clone>(rollout: &StepperRollout<'_, S>, stepper: &mut S) {
    if rollout.restarts {
        stepper.clone_from(rollout.stepper);
    }
}

/// Writes Aᵀ x, cut into parts of equal length.
pub(super) fn multiply_transposed(matrix: &[f64], x: &[f64], product: &mut [&mut [f64]]) {
    for part in product.iter_mut() {
        part.fill(0.0);
    }
    let parts = product.len();
    let rows = matrix.chunks_exact((matrix.len() / x.len().max(1)).max(1));
    for (row, x) in rows.zip(x).filter(|(_, x)| **x != 0.0) {
        for (part, row) in product.iter_mut().zip(row.chunks_exact(row.len() / parts)) {
            part.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry * x);
        }
    }
}
