//! The pullback of a rollout with checkpoints, from the last step to the first, over any number type.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::Stage;
use robot_dynamics_number::Scalar;

use super::rollout::Rollout;
use super::stages::{Accelerations, PullbackMemory, PullbackTree, pull_back_step};
use crate::motion::integrate::explicit::explicit_step;
use crate::motion::integrate::stage_memory::StageMemory;

/// The forces of a rollout, and the cotangents along it.
pub trait RolloutInputs<S> {
    /// The forces held over a step.
    fn torque(&mut self, step: usize, tau: &mut [S]);

    /// Adds the cotangents of a recorded state.
    fn add_cotangents(&mut self, sample: usize, by_position: &mut [S], by_velocity: &mut [S]);

    /// Receives the cotangent of a step's forces.
    fn record(&mut self, step: usize, by_force: &[S]);

    /// Called after some backward steps; returns whether to continue.
    fn go_on(&mut self, steps: usize) -> bool;
}

/// The memory of a rollout's pullback, cut from one slice.
struct RolloutPullbackMemory<'a, S> {
    stages: &'a mut [S],
    /// The states (q, v) at every `spacing`-th step, and those of one segment between two checkpoints.
    checkpoints: &'a mut [S],
    segment: &'a mut [S],
    /// v̇ of all stages of each step in the segment.
    accelerations: &'a mut [S],
    tau: &'a mut [S],
    scratch: [&'a mut [S]; 3],
    by_force: &'a mut [S],
}

/// The number of entries that a pullback with this many stages needs, with the spacing of
/// [`Rollout::spacing`].
pub fn memory_size(model: &Model, rollout: &Rollout, stages: usize, spacing: usize) -> usize {
    let states = rollout.steps.div_ceil(spacing) + spacing;
    let kept = states * (model.nq + model.nv) + spacing * stages * model.nv;
    PullbackMemory::<()>::size(model, stages) + kept + 5 * model.nv
}

/// Pulls the cotangents at the end of a rollout back to its start, in place, and adds the cotangents of the
/// parameters. Returns whether the start was reached.
#[inline(always)]
pub fn pull_back<S: Scalar, A: Accelerations<S>, C: RolloutInputs<S>>(
    model: &Model,
    (rollout, stages, spacing): (&Rollout, &[Stage], usize),
    (accelerations, course): (&mut A, &mut C),
    memory: &mut [S],
    (q, v): (&[S], &[S]),
    (by_q, by_v): (&mut [S], &mut [S]),
    parameters: &mut [S],
) -> bool {
    let (nv, state, steps) = (model.nv, model.nq + model.nv, rollout.steps);
    if steps == 0 {
        return true;
    }
    let h = S::from_f64(rollout.step);
    let mut rest = memory;
    let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
    let mut memory = RolloutPullbackMemory {
        stages: take(PullbackMemory::<S>::size(model, stages.len())),
        checkpoints: take(steps.div_ceil(spacing) * state),
        segment: take(spacing * state),
        accelerations: take(spacing * stages.len() * nv),
        tau: take(nv),
        scratch: [take(nv), take(nv), take(nv)],
        by_force: take(nv),
    };
    let (first_q, first_v) = memory.segment[..state].split_at_mut(model.nq);
    first_q.copy_from_slice(q);
    first_v.copy_from_slice(v);
    let mut way = RolloutSetup { model, rollout, stages, h, accelerations };
    // Forward: the first state of each segment.
    let segments = steps.div_ceil(spacing);
    for segment in 0..segments {
        let RolloutPullbackMemory { checkpoints, segment: states, .. } = &mut memory;
        checkpoints[segment * state..(segment + 1) * state].copy_from_slice(&states[..state]);
        if segment + 1 < segments {
            for step in segment * spacing..(segment + 1) * spacing {
                way.advance(course, &mut memory, (0, 0), step);
            }
        }
    }
    for segment in (0..segments).rev() {
        let first = segment * spacing;
        let count = spacing.min(steps - first);
        let RolloutPullbackMemory { checkpoints, segment: states, .. } = &mut memory;
        states[..state].copy_from_slice(&checkpoints[segment * state..(segment + 1) * state]);
        for k in 1..count {
            way.advance(course, &mut memory, (k - 1, k), first + k - 1);
        }
        for k in (0..count).rev() {
            let done = first + k + 1;
            if rollout.stride != 0 && done.is_multiple_of(rollout.stride) {
                course.add_cotangents(done / rollout.stride - 1, by_q, by_v);
            }
            let known = k + 1 < count;
            way.step_back(course, &mut memory, (k, first + k, known), (by_q, by_v), parameters);
        }
        if !course.go_on(count) {
            return false;
        }
    }
    true
}

/// The data that all steps of a rollout share.
struct RolloutSetup<'a, A, S> {
    model: &'a Model,
    rollout: &'a Rollout,
    stages: &'a [Stage],
    h: S,
    accelerations: &'a mut A,
}

impl<S: Scalar, A: Accelerations<S>> RolloutSetup<'_, A, S> {
    /// Advances from one state of the segment to another, possibly in the same memory.
    #[inline(always)]
    fn advance<C: RolloutInputs<S>>(
        &mut self,
        course: &mut C,
        memory: &mut RolloutPullbackMemory<'_, S>,
        (from, to): (usize, usize),
        step: usize,
    ) {
        let (model, nq, state) = (self.model, self.model.nq, self.model.nq + self.model.nv);
        let RolloutPullbackMemory { stages: numbers, segment, accelerations, tau, scratch, by_force, .. } =
            memory;
        let [force, acceleration, other] = scratch;
        course.torque(step, tau);
        let mut held = PullbackTree {
            model,
            accelerations: &mut *self.accelerations,
            dissipation: self.rollout.dissipation,
            tau,
            force,
            acceleration,
            by_stage_force: other,
            by_force,
            parameters: &mut [],
        };
        let mut numbers = StageMemory::new(model, self.stages.len(), numbers);
        let at = segment[from * state..(from + 1) * state].split_at(nq);
        let Ok(()) = explicit_step(model, self.stages, &mut held, self.h, &mut numbers, at);
        let (q, v) = segment[to * state..(to + 1) * state].split_at_mut(nq);
        q.copy_from_slice(numbers.q);
        v.copy_from_slice(numbers.v);
        let own = numbers.accelerations.len();
        accelerations[from * own..(from + 1) * own].copy_from_slice(numbers.accelerations);
    }

    /// The pullback of the step that starts at the segment's k-th state; `known` states whether that step
    /// was computed before.
    #[inline(always)]
    fn step_back<C: RolloutInputs<S>>(
        &mut self,
        course: &mut C,
        memory: &mut RolloutPullbackMemory<'_, S>,
        (k, step, known): (usize, usize, bool),
        cotangents: (&mut [S], &mut [S]),
        parameters: &mut [S],
    ) {
        let (model, nq, state) = (self.model, self.model.nq, self.model.nq + self.model.nv);
        let RolloutPullbackMemory { stages: numbers, segment, accelerations, tau, scratch, by_force, .. } =
            memory;
        let [force, acceleration, other] = scratch;
        course.torque(step, tau);
        let (q, v) = segment[k * state..(k + 1) * state].split_at(nq);
        let (by_q, by_v) = cotangents;
        let (at, h) = ([q, v, &**tau], self.h);
        if parameters.is_empty()
            && self.accelerations.pull_back_natively(model, at, h, (&mut *by_q, &mut *by_v), by_force)
        {
            course.record(step, by_force);
            return;
        }
        let cotangents = (by_q, by_v);
        by_force.fill(S::zero());
        let mut held = PullbackTree {
            model,
            accelerations: &mut *self.accelerations,
            dissipation: self.rollout.dissipation,
            tau,
            force,
            acceleration,
            by_stage_force: other,
            by_force,
            parameters,
        };
        let mut numbers = PullbackMemory::new(model, self.stages.len(), numbers);
        let own = self.stages.len() * model.nv;
        let kept = if known { &accelerations[k * own..(k + 1) * own] } else { &[] };
        let at = (q, v, kept);
        pull_back_step(model, self.stages, &mut held, self.h, &mut numbers, at, cotangents);
        course.record(step, by_force);
    }
}
