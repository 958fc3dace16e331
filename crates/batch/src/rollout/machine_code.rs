//! Rollouts by machine code, with one call of a kernel per step.

use robot_dynamics_core::model::native::Number;
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_integrators::Stage;
use robot_dynamics_native::Kernel;
use robot_dynamics_number::Float;
use robot_dynamics_simulation::Rollout;

use super::bad_rows::{bad_rows, spoil};
use super::job::Job;
use super::outcome::StateOutcomes;
use super::progress::SharedProgress;
use super::step::{BlockRollout, STEPS_PER_LOOK};
use super::torques::{PolicyInput, Torques};
use crate::distribution::for_each_part;
use crate::workspace::{BlockMemory, ThreadMemory};
use crate::{BatchWorkspace, block, machine_code};

/// The number of states that a thread advances at once, with one bit each for bad states.
const STATES: usize = u32::BITS as usize;

/// Advances all states, or returns the tables if there is no machine code of the step.
pub(super) fn move_natively<'a, T: Float + Number>(
    model: &Model,
    workspace: &BatchWorkspace<T>,
    (rollout, stages): (&Rollout, &[Stage]),
    torques: Torques<'_, T>,
    tables: [&'a mut [T]; 4],
    (shared, outcome): (&SharedProgress<'_>, &StateOutcomes),
) -> Result<(), [&'a mut [T]; 4]> {
    let step = NativeFunction::step(rollout.integrator, rollout.dissipation);
    let kernel = step.and_then(|step| machine_code::kernel(model, workspace, step));
    let Some(kernel) = kernel else { return Err(tables) };
    let batch = tables[0].len() / model.nq.max(1);
    for_each_part(workspace, batch, (STATES, 1), tables, &|memory, first, states, tables| {
        let [q, v, q_trajectory, v_trajectory] = tables;
        let mut job = Job { first, states, q, v, q_trajectory, v_trajectory };
        let (mut bits, mut finished) = (0, false);
        if !shared.is_cancelled() {
            let moving = KernelSteps { kernel, model, rollout, stages, torques };
            (bits, finished) = moving.advance(memory, &mut job, shared);
        }
        outcome.add(bits, finished, first..first + states);
    });
    Ok(())
}

/// A rollout whose steps a kernel computes.
struct KernelSteps<'a, T> {
    kernel: &'a Kernel<T>,
    model: &'a Model,
    rollout: &'a Rollout,
    stages: &'a [Stage],
    torques: Torques<'a, T>,
}

/// The numbers of all states of a job, state by state.
struct JobNumbers<'m, T> {
    q: &'m mut [T],
    v: &'m mut [T],
    /// The state after a step.
    q_end: &'m mut [T],
    v_end: &'m mut [T],
    tau: &'m mut [T],
    /// The length of each state's step.
    h: &'m mut [T],
    scratch: &'m mut [T],
}

impl<'m, T: Float + Number> JobNumbers<'m, T> {
    fn of(memory: &'m mut Vec<T>, model: &Model, states: usize, scratch: usize) -> Self {
        let (nq, nv) = (model.nq, model.nv);
        block::make_room(memory, states * (2 * nq + 3 * nv + 1) + scratch);
        let mut rest = &mut memory[..];
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        let (q, v) = (take(states * nq), take(states * nv));
        let (q_end, v_end) = (take(states * nq), take(states * nv));
        let (tau, h) = (take(states * nv), take(states));
        Self { q, v, q_end, v_end, tau, h, scratch: rest }
    }

    /// Takes the state after a step as the start of the next one.
    fn advance(&mut self) {
        core::mem::swap(&mut self.q, &mut self.q_end);
        core::mem::swap(&mut self.v, &mut self.v_end);
    }
}

impl<T: Float + Number> KernelSteps<'_, T> {
    /// A bit for each bad state, and whether all reached the end.
    fn advance(
        &self,
        memory: &mut ThreadMemory<T>,
        job: &mut Job<'_, T>,
        shared: &SharedProgress<'_>,
    ) -> (u32, bool) {
        let Self { kernel, model, rollout, torques, .. } = self;
        let (nv, states) = (model.nv, job.states);
        let way = (*model, *rollout, self.stages);
        let ThreadMemory { block, native } = memory;
        let mut numbers = JobNumbers::of(native, model, states, kernel.scratch_len());
        numbers.q.copy_from_slice(job.q);
        numbers.v.copy_from_slice(job.v);
        numbers.h.fill(T::from_f64(rollout.step));
        match torques {
            Torques::Held(table) => numbers.tau.copy_from_slice(&table[job.first * nv..][..states * nv]),
            Torques::Zero | Torques::EachStep(_) | Torques::Policy(_) => numbers.tau.fill(T::zero()),
        }
        let mut looked = 0;
        for done in 0..rollout.steps {
            if done == looked + STEPS_PER_LOOK {
                looked = done;
                if !shared.go_on((states * STEPS_PER_LOOK) as u64) {
                    return (0, false);
                }
            }
            self.set_torques(job, done, &mut numbers);
            let JobNumbers { q, v, q_end, v_end, tau, h, scratch } = &mut numbers;
            kernel_step(kernel, way, block, states, [q, v, tau, h], (q_end, v_end), scratch);
            numbers.advance();
            if rollout.stride != 0 && (done + 1) % rollout.stride == 0 {
                self.record_sample(job, (done + 1) / rollout.stride - 1, &numbers);
            }
        }
        let bad = bad_rows(&[numbers.q, numbers.v], states);
        if bad != 0 {
            spoil(bad, numbers.q, states);
            spoil(bad, numbers.v, states);
        }
        job.q.copy_from_slice(numbers.q);
        job.v.copy_from_slice(numbers.v);
        shared.go_on((states * (rollout.steps - looked)) as u64);
        (bad, true)
    }

    /// Sets the torques of step `done` that change from step to step.
    fn set_torques(&self, job: &Job<'_, T>, done: usize, numbers: &mut JobNumbers<'_, T>) {
        let (nv, states) = (self.model.nv, job.states);
        let JobNumbers { q, v, tau, .. } = numbers;
        match self.torques {
            Torques::Zero | Torques::Held(_) => {}
            Torques::EachStep(table) => {
                for state in 0..states {
                    let row = ((job.first + state) * self.rollout.steps + done) * nv;
                    tau[state * nv..][..nv].copy_from_slice(&table[row..][..nv]);
                }
            }
            Torques::Policy(policy) => {
                let (first, time) = (job.first, done as f64 * self.rollout.step);
                policy(PolicyInput { first, states, step: done, time, q, v }, tau);
            }
        }
    }

    /// Copies all states to sample `sample` of the trajectories.
    fn record_sample(&self, job: &mut Job<'_, T>, sample: usize, numbers: &JobNumbers<'_, T>) {
        let (nq, nv, samples) = (self.model.nq, self.model.nv, self.rollout.samples());
        for state in 0..job.states {
            let row = state * samples + sample;
            job.q_trajectory[row * nq..][..nq].copy_from_slice(&numbers.q[state * nq..][..nq]);
            job.v_trajectory[row * nv..][..nv].copy_from_slice(&numbers.v[state * nv..][..nv]);
        }
    }
}

/// Takes one step of some states from (q, v) to `end`. States with an angle outside the range of the kernel's
/// sine use the recursion.
pub(super) fn kernel_step<T: Float + Number>(
    kernel: &Kernel<T>,
    way: (&Model, &Rollout, &[Stage]),
    block: &mut BlockMemory,
    states: usize,
    [q, v, tau, h]: [&[T]; 4],
    (q_end, v_end): (&mut [T], &mut [T]),
    scratch: &mut [T],
) {
    let (nq, nv) = (way.0.nq, way.0.nv);
    let mut far = Vec::new();
    let results = &mut [&mut *q_end, &mut *v_end];
    kernel.call_rows(states, &[q, v, tau, h], results, scratch, |state| far.push(state));
    for state in far {
        let (of_q, of_v) = (state * nq..(state + 1) * nq, state * nv..(state + 1) * nv);
        q_end[of_q.clone()].copy_from_slice(&q[of_q.clone()]);
        v_end[of_v.clone()].copy_from_slice(&v[of_v.clone()]);
        step_by_recursion(way, block, &tau[of_v.clone()], &mut q_end[of_q], &mut v_end[of_v]);
    }
}

/// One step of one state with an angle outside the range of the code's sine.
fn step_by_recursion<T: Float>(
    (model, rollout, stages): (&Model, &Rollout, &[Stage]),
    block: &mut BlockMemory,
    tau: &[T],
    q: &mut [T],
    v: &mut [T],
) {
    let one_step = &rollout.one_step();
    let shared = &SharedProgress::of_one_step();
    let job = Job { first: 0, states: 1, q, v, q_trajectory: &mut [], v_trajectory: &mut [] };
    let outputs = (&mut 0, &mut false);
    let torques = Torques::Held(tau);
    block::run(block, BlockRollout { model, rollout: one_step, stages, torques, job, shared, outputs });
}
