//! Rollouts by machine code, with one call of a kernel per step.

use robot_dynamics_core::model::native::Number;
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_integrators::Stage;
use robot_dynamics_native::Kernel;
use robot_dynamics_number::Float;
use robot_dynamics_simulation::Rollout;

use super::job::Job;
use super::outcome::Outcome;
use super::progress::Shared;
use super::step::{Advance, STEPS_PER_LOOK};
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
    (shared, outcome): (&Shared<'_>, &Outcome),
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

impl<T: Float + Number> KernelSteps<'_, T> {
    /// A bit for each bad state, and whether all reached the end.
    fn advance(
        &self,
        memory: &mut ThreadMemory<T>,
        job: &mut Job<'_, T>,
        shared: &Shared<'_>,
    ) -> (u32, bool) {
        let Self { kernel, model, rollout, torques, .. } = self;
        let (nq, nv, states) = (model.nq, model.nv, job.states);
        let ThreadMemory { block, native: numbers } = memory;
        block::make_room(numbers, states * (2 * nq + 3 * nv + 1) + kernel.scratch_len());
        let mut rest = &mut numbers[..];
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        let (mut q, mut v) = (take(states * nq), take(states * nv));
        let (mut q_end, mut v_end) = (take(states * nq), take(states * nv));
        let (tau, steps) = (take(states * nv), take(states));
        let scratch = rest;
        q.copy_from_slice(job.q);
        v.copy_from_slice(job.v);
        steps.fill(T::from_f64(rollout.step));
        match torques {
            Torques::Held(table) => tau.copy_from_slice(&table[job.first * nv..][..states * nv]),
            Torques::Zero | Torques::EachStep(_) | Torques::Policy(_) => tau.fill(T::zero()),
        }
        let samples = rollout.samples();
        let mut looked = 0;
        for done in 0..rollout.steps {
            if done == looked + STEPS_PER_LOOK {
                looked = done;
                if !shared.go_on((states * STEPS_PER_LOOK) as u64) {
                    return (0, false);
                }
            }
            match torques {
                Torques::Zero | Torques::Held(_) => {}
                Torques::EachStep(table) => {
                    for state in 0..states {
                        let row = ((job.first + state) * rollout.steps + done) * nv;
                        tau[state * nv..][..nv].copy_from_slice(&table[row..][..nv]);
                    }
                }
                Torques::Policy(policy) => {
                    let (first, time) = (job.first, done as f64 * rollout.step);
                    policy(PolicyInput { first, states, step: done, time, q, v }, tau);
                }
            }
            let mut far = Vec::new();
            let results = &mut [&mut *q_end, &mut *v_end];
            kernel.call_rows(states, &[q, v, tau, steps], results, scratch, |state| far.push(state));
            for state in far {
                let (of_q, of_v) = (state * nq..(state + 1) * nq, state * nv..(state + 1) * nv);
                q_end[of_q.clone()].copy_from_slice(&q[of_q.clone()]);
                v_end[of_v.clone()].copy_from_slice(&v[of_v.clone()]);
                let way = (self.model, self.rollout, self.stages);
                step_by_recursion(way, block, &tau[of_v.clone()], &mut q_end[of_q], &mut v_end[of_v]);
            }
            core::mem::swap(&mut q, &mut q_end);
            core::mem::swap(&mut v, &mut v_end);
            if rollout.stride != 0 && (done + 1) % rollout.stride == 0 {
                let sample = (done + 1) / rollout.stride - 1;
                for state in 0..states {
                    let row = state * samples + sample;
                    job.q_trajectory[row * nq..][..nq].copy_from_slice(&q[state * nq..][..nq]);
                    job.v_trajectory[row * nv..][..nv].copy_from_slice(&v[state * nv..][..nv]);
                }
            }
        }
        let mut bad = 0;
        for state in 0..states {
            let (q, v) = (&mut q[state * nq..][..nq], &mut v[state * nv..][..nv]);
            if !q.iter().chain(&*v).copied().all(Float::is_finite) {
                bad |= 1 << state;
                q.fill(T::from_f64(f64::NAN));
                v.fill(T::from_f64(f64::NAN));
            }
        }
        job.q.copy_from_slice(q);
        job.v.copy_from_slice(v);
        shared.go_on((states * (rollout.steps - looked)) as u64);
        (bad, true)
    }
}

/// One step of one state with an angle outside the range of the code's sine.
pub(super) fn step_by_recursion<T: Float>(
    (model, rollout, stages): (&Model, &Rollout, &[Stage]),
    block: &mut BlockMemory,
    tau: &[T],
    q: &mut [T],
    v: &mut [T],
) {
    let one_step = &rollout.one_step();
    let shared = &Shared::of_one_step();
    let job = Job { first: 0, states: 1, q, v, q_trajectory: &mut [], v_trajectory: &mut [] };
    let outputs = (&mut 0, &mut false);
    let torques = Torques::Held(tau);
    block::run(block, Advance { model, rollout: one_step, stages, torques, job, shared, outputs });
}
