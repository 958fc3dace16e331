//! The pullback of rollouts by machine code, with one kernel per forward step and one per backward step.

use robot_dynamics_core::model::native::Number;
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_integrators::Stage;
use robot_dynamics_native::Kernel;
use robot_dynamics_number::Float;
use robot_dynamics_simulation::{Rollout, TrajectoryCotangents};

use super::backward_pass::Backward;
use super::inputs::RolloutPullbackInputs;
use crate::distribution::for_each_part;
use crate::rollout::bad_rows::{bad_rows, spoil};
use crate::rollout::machine_code::kernel_step;
use crate::rollout::outcome::StateOutcomes;
use crate::rollout::progress::SharedProgress;
use crate::rollout::torques::Torques;
use crate::workspace::{BlockMemory, ThreadMemory};
use crate::{BatchWorkspace, block, machine_code};

/// The number of states that a thread processes at once, with one bit each for bad states.
const STATES: usize = u32::BITS as usize;

/// Pulls all states back. Returns the result tables if cotangents of parameters are requested, or if there is
/// no machine code.
pub(super) fn pull_back_natively<'a, T: Float + Number>(
    model: &Model,
    workspace: &BatchWorkspace<T>,
    (rollout, stages, spacing): (&Rollout, &[Stage], usize),
    given: &RolloutPullbackInputs<'_, T>,
    results: [&'a mut [T]; 4],
    (shared, outcome): (&SharedProgress<'_>, &StateOutcomes),
) -> Result<(), [&'a mut [T]; 4]> {
    let kernels = || {
        let (row, dissipation) = (rollout.integrator, rollout.dissipation);
        let step = machine_code::kernel(model, workspace, NativeFunction::step(row, dissipation)?)?;
        let function = NativeFunction::step_pullback(row, dissipation)?;
        Some((step, machine_code::kernel(model, workspace, function)?))
    };
    if !results[3].is_empty() || rollout.steps == 0 {
        return Err(results);
    }
    let Some((step, pullback)) = kernels() else { return Err(results) };
    let batch = results[0].len() / model.nv;
    for_each_part(workspace, batch, (STATES, 1), results, &|memory, first, states, results| {
        let (mut bits, mut finished) = (0, false);
        if !shared.is_cancelled() {
            let way = KernelPasses { step, pullback, model, rollout, stages, spacing, given, first, states };
            (bits, finished) = way.run(memory, results, shared);
        }
        outcome.add(bits, finished, first..first + states);
    });
    Ok(())
}

/// The forward and backward pass of some states.
struct KernelPasses<'a, T> {
    step: &'a Kernel<T>,
    pullback: &'a Kernel<T>,
    model: &'a Model,
    rollout: &'a Rollout,
    stages: &'a [Stage],
    /// The number of steps between checkpoints.
    spacing: usize,
    given: &'a RolloutPullbackInputs<'a, T>,
    first: usize,
    states: usize,
}

/// Tables of some states, cut from one slice.
struct RolloutPullbackTables<'a, T> {
    /// q and v of all states: at every `spacing`-th step, at each step of one segment between checkpoints,
    /// and after a step.
    checkpoints: &'a mut [T],
    segment: &'a mut [T],
    end: &'a mut [T],
    tau: &'a mut [T],
    /// The length of the step.
    steps: &'a mut [T],
    /// Each row holds the cotangents of q and of v.
    cotangents: &'a mut [T],
    by_position: &'a mut [T],
    by_velocity: &'a mut [T],
    by_force: &'a mut [T],
    /// Sums over the steps.
    by_held_force: &'a mut [T],
    scratch: &'a mut [T],
}

impl<'a, T: Float + Number> RolloutPullbackTables<'a, T> {
    fn new(way: &KernelPasses<'_, T>, numbers: &'a mut Vec<T>) -> Self {
        let KernelPasses { step, pullback, model, rollout, spacing, states, .. } = *way;
        let (of_state, nv) = (states * (model.nq + model.nv), states * model.nv);
        let of_checkpoints = rollout.steps.div_ceil(spacing) * of_state;
        let of_scratch = step.scratch_len().max(pullback.scratch_len());
        let size = of_checkpoints + (spacing + 1) * of_state + states + 7 * nv + of_scratch;
        block::make_room(numbers, size);
        let mut rest = &mut numbers[..];
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        Self {
            checkpoints: take(of_checkpoints),
            segment: take(spacing * of_state),
            end: take(of_state),
            tau: take(nv),
            steps: take(states),
            cotangents: take(2 * nv),
            by_position: take(nv),
            by_velocity: take(nv),
            by_force: take(nv),
            by_held_force: take(nv),
            scratch: take(of_scratch),
        }
    }
}

impl<T: Float + Number> KernelPasses<'_, T> {
    /// A bit for each bad state, and whether all reached the start.
    fn run(
        &self,
        memory: &mut ThreadMemory<T>,
        results: [&mut [T]; 4],
        shared: &SharedProgress<'_>,
    ) -> (u32, bool) {
        let Self { model, rollout, spacing, given, first, states, .. } = *self;
        let [by_position, by_velocity, force_rows, _] = results;
        let ThreadMemory { block, native: numbers } = memory;
        let memory = &mut RolloutPullbackTables::new(self, numbers);
        let (of_q, of_v) = (states * model.nq, states * model.nv);
        let of_state = of_q + of_v;
        let q = &given.q[first * model.nq..][..of_q];
        let v = &given.v[first * model.nv..][..of_v];
        memory.segment[..of_q].copy_from_slice(q);
        memory.segment[of_q..of_state].copy_from_slice(v);
        memory.steps.fill(T::from_f64(rollout.step));
        memory.by_position.copy_from_slice(by_position);
        memory.by_velocity.copy_from_slice(by_velocity);
        memory.by_held_force.fill(T::zero());
        let mut bad = bad_rows(&[q, v, by_position, by_velocity], states);
        // Forward: the first state of each segment.
        let segments = rollout.steps.div_ceil(spacing);
        for segment in 0..segments {
            let of_checkpoint = segment * of_state..(segment + 1) * of_state;
            memory.checkpoints[of_checkpoint].copy_from_slice(&memory.segment[..of_state]);
            if segment + 1 < segments {
                for step in segment * spacing..(segment + 1) * spacing {
                    self.advance(block, memory, 0, step);
                    memory.segment[..of_state].copy_from_slice(memory.end);
                }
            }
        }
        for segment in (0..segments).rev() {
            let start = segment * spacing;
            let count = spacing.min(rollout.steps - start);
            let of_checkpoint = segment * of_state..(segment + 1) * of_state;
            memory.segment[..of_state].copy_from_slice(&memory.checkpoints[of_checkpoint]);
            for k in 1..count {
                self.advance(block, memory, k - 1, start + k - 1);
                memory.segment[k * of_state..(k + 1) * of_state].copy_from_slice(memory.end);
            }
            for k in (0..count).rev() {
                bad |= self.step_back(block, memory, k, start + k);
                self.take(start + k, memory, force_rows);
            }
            if !shared.go_on((states * count) as u64) {
                return (0, false);
            }
        }
        bad |= bad_rows(&[memory.by_position, memory.by_velocity, memory.by_held_force], states);
        by_position.copy_from_slice(memory.by_position);
        by_velocity.copy_from_slice(memory.by_velocity);
        if matches!(given.torques, Torques::Held(_)) {
            force_rows.copy_from_slice(memory.by_held_force);
        }
        if bad != 0 {
            for rows in [by_position, by_velocity, force_rows] {
                spoil(bad, rows, states);
            }
        }
        (bad, true)
    }

    /// The forces of a step.
    fn torque(&self, step: usize, tau: &mut [T]) {
        let Self { model, rollout, given, first, .. } = *self;
        match given.torques {
            Torques::Zero | Torques::Policy(_) => tau.fill(T::zero()),
            Torques::Held(rows) => tau.copy_from_slice(&rows[first * model.nv..][..tau.len()]),
            Torques::EachStep(rows) => {
                for (state, row) in tau.chunks_exact_mut(model.nv).enumerate() {
                    let at = ((first + state) * rollout.steps + step) * model.nv;
                    row.copy_from_slice(&rows[at..at + model.nv]);
                }
            }
        }
    }

    /// Adds the cotangent of a step's held forces, or writes that of the step's own forces.
    fn take(&self, step: usize, memory: &mut RolloutPullbackTables<'_, T>, force_rows: &mut [T]) {
        let Self { model, rollout, given, .. } = *self;
        let RolloutPullbackTables { by_force, by_held_force, .. } = memory;
        match given.torques {
            Torques::Zero | Torques::Policy(_) => {}
            Torques::Held(_) => by_held_force.iter_mut().zip(&**by_force).for_each(|(sum, &x)| *sum += x),
            Torques::EachStep(_) => {
                for (state, row) in by_force.chunks_exact(model.nv).enumerate() {
                    let at = (state * rollout.steps + step) * model.nv;
                    force_rows[at..at + model.nv].copy_from_slice(row);
                }
            }
        }
    }

    /// Advances from the k-th states of the segment to its end.
    fn advance(
        &self,
        block: &mut BlockMemory,
        memory: &mut RolloutPullbackTables<'_, T>,
        k: usize,
        step: usize,
    ) {
        let Self { model, rollout, stages, states, .. } = *self;
        let (nq, nv) = (model.nq, model.nv);
        let RolloutPullbackTables { segment, end, tau, steps, scratch, .. } = memory;
        self.torque(step, tau);
        let (q, v) = segment[k * states * (nq + nv)..][..states * (nq + nv)].split_at(states * nq);
        let (q_end, v_end) = end.split_at_mut(states * nq);
        let way = (model, rollout, stages);
        kernel_step(self.step, way, block, states, [q, v, tau, steps], (q_end, v_end), scratch);
    }

    /// The pullback of the step from the k-th states of the segment; returns a bit for each state whose
    /// cotangents are not finite.
    fn step_back(
        &self,
        block: &mut BlockMemory,
        memory: &mut RolloutPullbackTables<'_, T>,
        k: usize,
        step: usize,
    ) -> u32 {
        let Self { model, rollout, states, .. } = *self;
        let (nq, nv) = (model.nq, model.nv);
        let RolloutPullbackTables {
            segment,
            tau,
            steps,
            cotangents,
            by_position,
            by_velocity,
            by_force,
            scratch,
            ..
        } = memory;
        if rollout.stride != 0 && (step + 1).is_multiple_of(rollout.stride) {
            self.add_cotangents((step + 1) / rollout.stride - 1, by_position, by_velocity);
        }
        self.torque(step, tau);
        let rows = by_position.chunks_exact(nv).zip(by_velocity.chunks_exact(nv));
        for (row, (of_q, of_v)) in cotangents.chunks_exact_mut(2 * nv).zip(rows) {
            row[..nv].copy_from_slice(of_q);
            row[nv..].copy_from_slice(of_v);
        }
        let (q, v) = segment[k * states * (nq + nv)..][..states * (nq + nv)].split_at(states * nq);
        let mut far = Vec::new();
        let results = &mut [&mut **by_position, &mut **by_velocity, &mut **by_force];
        let arguments = &[q, v, tau, steps, cotangents];
        let is_finite = self.pullback.call_rows(states, arguments, results, scratch, |state| far.push(state));
        if is_finite && far.is_empty() {
            return 0;
        }
        for state in far {
            let (of_q, of_v) = (state * nq..(state + 1) * nq, state * nv..(state + 1) * nv);
            let (cotangent_of_q, cotangent_of_v) = cotangents[2 * state * nv..][..2 * nv].split_at(nv);
            by_position[of_v.clone()].copy_from_slice(cotangent_of_q);
            by_velocity[of_v.clone()].copy_from_slice(cotangent_of_v);
            let (q, v, tau) = (&q[of_q], &v[of_v.clone()], &tau[of_v.clone()]);
            let given = &RolloutPullbackInputs {
                spacing: 1,
                torques: Torques::Held(tau),
                q,
                v,
                trajectory: TrajectoryCotangents::default(),
            };
            let results = [&mut **by_position, &mut **by_velocity, &mut **by_force]
                .map(|table| &mut table[of_v.clone()]);
            self.step_back_by_recursion(block, given, results);
        }
        bad_rows(&[by_position, by_velocity, by_force], states)
    }

    /// Adds the cotangents of a recorded state.
    fn add_cotangents(&self, sample: usize, by_position: &mut [T], by_velocity: &mut [T]) {
        let Self { model, rollout, given, first, .. } = *self;
        let nv = model.nv;
        for (rows, to) in
            [(given.trajectory.by_position, by_position), (given.trajectory.by_velocity, by_velocity)]
        {
            for (state, row) in to.chunks_exact_mut(nv).enumerate() {
                let at = ((first + state) * rollout.samples() + sample) * nv;
                row.iter_mut().zip(&rows[at..at + nv]).for_each(|(x, &y)| *x += y);
            }
        }
    }

    /// The pullback of one step of one state with an angle outside the range of the code's sine.
    fn step_back_by_recursion(
        &self,
        block: &mut BlockMemory,
        given: &RolloutPullbackInputs<'_, T>,
        [by_position, by_velocity, by_force]: [&mut [T]; 3],
    ) {
        let Self { model, rollout, stages, .. } = *self;
        let rollout = &rollout.one_step();
        let shared = &SharedProgress::of_one_step();
        let (outputs, stages) = ((&mut 0, &mut false), (stages, 1));
        let results = [by_position, by_velocity, by_force, &mut []];
        let backward =
            Backward { model, rollout, stages, given, first: 0, states: 1, results, shared, outputs };
        block::run(block, backward);
    }
}
