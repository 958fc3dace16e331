//! Rollouts: the states stay on the device from step to step.

use robot_dynamics::InvalidInput;
use robot_dynamics::batch::{
    BadStates, RolloutError, RolloutObserver, RolloutProgress, RolloutStates, Torques,
};
use robot_dynamics::derivatives::Rollout;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_generate::Function;

use crate::backend::{Backend, Command};
use crate::machine::{Machine, check_table};
use crate::robot::{mark_not_finite, marked_states};
use crate::{DeviceError, DeviceFloat};

/// The largest number of steps between calls of the progress callback.
const STEPS_PER_CALLBACK: usize = 64;

/// The function for one step of an integrator.
fn step_of(integrator: Integrator) -> Option<Function> {
    match integrator {
        Integrator::SemiImplicitEuler => Some(Function::SemiImplicitEulerStep),
        Integrator::RungeKutta4 => Some(Function::Rk4Step),
        _ => None,
    }
}

/// Tables of a rollout on the device. Steps alternate between two tables for each of q and v.
#[derive(Clone, Copy)]
enum RolloutTable {
    Q0,
    V0,
    Q1,
    V1,
    Tau,
    H,
    /// Torques of a chunk of steps: \[steps\]\[states\]\[nv\].
    EachTau,
    /// Samples of a chunk of steps: \[samples\]\[states\]\[nq\] and \[nv\].
    QSamples,
    VSamples,
}

/// The tables of even and of odd steps: q and v before the step, q and v after it.
const PING_PONG: [[RolloutTable; 4]; 2] = [
    [RolloutTable::Q0, RolloutTable::V0, RolloutTable::Q1, RolloutTable::V1],
    [RolloutTable::Q1, RolloutTable::V1, RolloutTable::Q0, RolloutTable::V0],
];

/// A rollout, and its division into launches.
struct RolloutPlan<'a, T> {
    rollout: &'a Rollout,
    torques: Torques<'a, T>,
    /// The number of states at once.
    most: usize,
    /// The number of steps in a chunk.
    chunk: usize,
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    /// See [`Batches::rollout`](crate::Batches::rollout).
    #[track_caller]
    pub(crate) fn roll_out(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        buffers: RolloutStates<'_, T>,
        progress: RolloutObserver<'_>,
    ) -> Result<(), DeviceError> {
        let (h, function) = Self::check_rollout(rollout)?;
        let at = self.find(&function)?;
        if !rollout.dissipation && self.robot.dissipates {
            return Err(DeviceError::Dissipation { robot: self.robot.name.clone() });
        }
        let batch = self.check_tables(rollout, torques, &buffers)?;
        let tau = match torques {
            Torques::Held(tau) | Torques::EachStep(tau) => tau,
            Torques::Zero | Torques::Policy(_) => &[],
        };
        let mut bad: Vec<usize> =
            marked_states(&self.bad_states_of([buffers.q, buffers.v, tau]), 0).collect();
        if batch == 0 || rollout.steps == 0 {
            return Ok(BadStates::unless_empty(bad, batch)?);
        }
        let plan = self.plan(&function, rollout, torques, batch)?;
        self.reserve(&plan.sizes(self.robot.nq, self.robot.nv))?;
        let steps = vec![h; plan.most];
        self.backend.write(self.buffer(RolloutTable::H as usize), bytemuck::cast_slice(&steps))?;
        self.run_launches(at, &plan, buffers, batch, progress, &mut bad)
    }

    /// The step in the device's precision, and the function that computes it.
    fn check_rollout(rollout: &Rollout) -> Result<(T, Function), DeviceError> {
        let h = T::from_f64(rollout.step);
        // A step that is positive in f64 may be 0 or infinite in f32.
        if !(h.is_finite() && h > T::zero()) {
            let range = format!("positive and finite in {}", std::any::type_name::<T>());
            let error = InvalidInput::out_of_range("the step", rollout.step, "s", range);
            return Err(RolloutError::from(error).into());
        }
        let integrator = rollout.integrator;
        Ok((h, step_of(integrator).ok_or(DeviceError::NoStep { integrator })?))
    }

    /// Divides a rollout by the limits of the device.
    fn plan<'a>(
        &self,
        function: &Function,
        rollout: &'a Rollout,
        torques: Torques<'a, T>,
        batch: usize,
    ) -> Result<RolloutPlan<'a, T>, DeviceError> {
        let widest = self.robot.nq.max(self.robot.nv);
        let most = self.states_at_once(function, widest)?.min(batch);
        let fits = self.backend.most_bytes() / (most * widest * size_of::<T>());
        let chunk = STEPS_PER_CALLBACK.min(fits.max(1)).min(rollout.steps);
        Ok(RolloutPlan { rollout, torques, most, chunk })
    }

    /// Simulates all states, as many at once as the device takes; states that are or become invalid are added
    /// to `bad`.
    fn run_launches(
        &self,
        at: usize,
        plan: &RolloutPlan<'_, T>,
        buffers: RolloutStates<'_, T>,
        batch: usize,
        progress: RolloutObserver<'_>,
        bad: &mut Vec<usize>,
    ) -> Result<(), DeviceError> {
        let (nq, nv) = (self.robot.nq, self.robot.nv);
        let RolloutStates { q, v, q_trajectory, v_trajectory } = buffers;
        let (most, samples) = (plan.most, plan.rollout.samples());
        let total = batch as u64 * plan.rollout.steps as u64;
        let (mut done, mut is_cancelled) = (0, false);
        for first in (0..batch).step_by(most) {
            let states = most.min(batch - first);
            let q = &mut q[first * nq..][..states * nq];
            let v = &mut v[first * nv..][..states * nv];
            let trajectory = (
                &mut q_trajectory[first * samples * nq..][..states * samples * nq],
                &mut v_trajectory[first * samples * nv..][..states * samples * nv],
            );
            let mut go_on = |steps: usize| {
                done += (states * steps) as u64;
                is_cancelled = progress(RolloutProgress::new(done, total)).is_break();
                !is_cancelled
            };
            let is_finished = self.advance(at, plan, (first, states), (q, v), trajectory, &mut go_on)?;
            let end = if is_finished { first + states } else { first };
            if is_cancelled && end < batch {
                return Err(RolloutError::Cancelled { unfinished: (end..batch).collect(), batch }.into());
            }
            bad.extend(marked_states(&self.bad_states_of([q, v, &[]]), first));
        }
        let bad = BadStates::unless_empty(core::mem::take(bad), batch);
        if let Err(BadStates { states, .. }) = &bad {
            for state in states {
                q[state * nq..][..nq].fill(T::NAN);
                v[state * nv..][..nv].fill(T::NAN);
            }
        }
        Ok(bad?)
    }

    /// The number of states. Panics with both lengths if a table has the wrong one.
    #[track_caller]
    fn check_tables(
        &self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        buffers: &RolloutStates<'_, T>,
    ) -> Result<usize, DeviceError> {
        let (nq, nv) = (self.robot.nq, self.robot.nv);
        let len = buffers.q.len();
        assert!(len.is_multiple_of(nq), "q has {len} numbers, not a multiple of nq = {nq}");
        let batch = len / nq;
        check_table("v", buffers.v.len(), batch, nv);
        check_table("the trajectory of q", buffers.q_trajectory.len(), batch, rollout.samples() * nq);
        check_table("the trajectory of v", buffers.v_trajectory.len(), batch, rollout.samples() * nv);
        match torques {
            Torques::Zero => {}
            Torques::Held(tau) => check_table("tau", tau.len(), batch, nv),
            Torques::EachStep(tau) => check_table("tau", tau.len(), batch, rollout.steps * nv),
            Torques::Policy(_) => return Err(DeviceError::Policy),
        }
        Ok(batch)
    }

    /// For each state, whether a number in q, v or τ is not finite, or q is invalid.
    fn bad_states_of(&self, [q, v, tau]: [&[T]; 3]) -> Vec<bool> {
        let mut is_bad = vec![false; q.len() / self.robot.nq];
        for rows in [q, v, tau] {
            mark_not_finite(rows, &mut is_bad);
        }
        self.robot.mark_invalid(q, &mut is_bad);
        is_bad
    }

    /// Simulates some states to the end of the rollout. Returns `false`, with the states unchanged, if
    /// `go_on` does.
    fn advance(
        &self,
        at: usize,
        plan: &RolloutPlan<'_, T>,
        (first, states): (usize, usize),
        (q, v): (&mut [T], &mut [T]),
        mut trajectory: (&mut [T], &mut [T]),
        go_on: &mut dyn FnMut(usize) -> bool,
    ) -> Result<bool, DeviceError> {
        let (rollout, backend) = (plan.rollout, &*self.backend);
        let launches = self.start(at, plan, (first, states), (q, v))?;
        let mut taken = 0;
        while taken < rollout.steps {
            let steps = taken..(taken + plan.chunk).min(rollout.steps);
            if let Torques::EachStep(tau) = plan.torques {
                let rows = plan.torques_by_step(tau, first, states, steps.clone(), self.robot.nv);
                backend.write(self.table(RolloutTable::EachTau), bytemuck::cast_slice(&rows))?;
            }
            let (commands, sampled) = self.commands(plan, &launches, states, steps.clone());
            backend.submit(&commands)?;
            if sampled > 0 {
                let before = taken / rollout.stride;
                self.read_samples(&mut trajectory, rollout.samples(), states, before..before + sampled)?;
            } else {
                backend.wait()?;
            }
            taken = steps.end;
            if !go_on(steps.len()) && taken < rollout.steps {
                return Ok(false);
            }
        }
        let [.., q_end, v_end] = PING_PONG[(rollout.steps - 1) % 2];
        backend.read(self.table(q_end), bytemuck::cast_slice_mut(q))?;
        backend.read(self.table(v_end), bytemuck::cast_slice_mut(v))?;
        Ok(true)
    }

    fn table(&self, table: RolloutTable) -> &B::Buffer {
        self.buffer(table as usize)
    }

    /// Copies states and initial torques to the device, and binds the tables of even and of odd steps.
    fn start(
        &self,
        at: usize,
        plan: &RolloutPlan<'_, T>,
        (first, states): (usize, usize),
        (q, v): (&[T], &[T]),
    ) -> Result<[B::Launch; 2], DeviceError> {
        let (nq, nv, size) = (self.robot.nq, self.robot.nv, size_of::<T>());
        let backend = &*self.backend;
        backend.write(self.table(RolloutTable::Q0), bytemuck::cast_slice(q))?;
        backend.write(self.table(RolloutTable::V0), bytemuck::cast_slice(v))?;
        let tau = plan.start_torques(first, states, nv);
        backend.write(self.table(RolloutTable::Tau), bytemuck::cast_slice(&tau))?;
        Ok(PING_PONG.map(|[q, v, q_next, v_next]| {
            let widths =
                [(q, nq), (v, nv), (RolloutTable::Tau, nv), (RolloutTable::H, 1), (q_next, nq), (v_next, nv)];
            let tables = widths.map(|(table, width)| (self.table(table), width * size));
            backend.bind(&self.function(at).kernel, &tables, states)
        }))
    }

    /// The commands for some steps: torques of each step, the step, and samples of the trajectory; and how
    /// many samples these are.
    fn commands<'a>(
        &'a self,
        plan: &RolloutPlan<'_, T>,
        launches: &'a [B::Launch; 2],
        states: usize,
        steps: core::ops::Range<usize>,
    ) -> (Vec<Command<'a, B>>, usize) {
        let (nq, nv, size) = (self.robot.nq, self.robot.nv, size_of::<T>());
        let (stride, first) = (plan.rollout.stride, steps.start);
        let (mut commands, mut sampled) = (Vec::new(), 0);
        for step in steps {
            if matches!(plan.torques, Torques::EachStep(_)) {
                let bytes = states * nv * size;
                let (from, to) = (self.table(RolloutTable::EachTau), self.table(RolloutTable::Tau));
                commands.push(Command::Copy { from, from_at: (step - first) * bytes, to, to_at: 0, bytes });
            }
            commands.push(Command::Run(&launches[step % 2]));
            if stride != 0 && (step + 1).is_multiple_of(stride) {
                let [.., q_next, v_next] = PING_PONG[step % 2];
                for (from, to, width) in
                    [(q_next, RolloutTable::QSamples, nq), (v_next, RolloutTable::VSamples, nv)]
                {
                    let bytes = states * width * size;
                    let (from, to) = (self.table(from), self.table(to));
                    commands.push(Command::Copy { from, from_at: 0, to, to_at: sampled * bytes, bytes });
                }
                sampled += 1;
            }
        }
        (commands, sampled)
    }

    /// Reads samples from the device into the trajectories, which have `samples` rows for each state.
    fn read_samples(
        &self,
        (q_trajectory, v_trajectory): &mut (&mut [T], &mut [T]),
        samples: usize,
        states: usize,
        read: core::ops::Range<usize>,
    ) -> Result<(), DeviceError> {
        for (table, rows, width) in [
            (RolloutTable::QSamples, &mut **q_trajectory, self.robot.nq),
            (RolloutTable::VSamples, &mut **v_trajectory, self.robot.nv),
        ] {
            let mut found = vec![T::zero(); read.len() * states * width];
            self.backend.read(self.table(table), bytemuck::cast_slice_mut(&mut found))?;
            for (k, found) in found.chunks(width).enumerate() {
                let (sample, state) = (read.start + k / states, k % states);
                rows[(state * samples + sample) * width..][..width].copy_from_slice(found);
            }
        }
        Ok(())
    }
}

impl<T: DeviceFloat> RolloutPlan<'_, T> {
    /// The count of numbers of each table, in the order of [`RolloutTable`].
    fn sizes(&self, nq: usize, nv: usize) -> Vec<usize> {
        let of_steps =
            |is_there: bool, width: usize| if is_there { self.most * self.chunk * width } else { 1 };
        let is_each = matches!(self.torques, Torques::EachStep(_));
        let is_sampled = self.rollout.stride != 0;
        let state = [nq, nv, nq, nv, nv, 1].map(|width| width * self.most);
        let chunk = [of_steps(is_each, nv), of_steps(is_sampled, nq), of_steps(is_sampled, nv)];
        state.into_iter().chain(chunk).collect()
    }

    /// The initial torques: constant ones, or zero.
    fn start_torques(&self, first: usize, states: usize, nv: usize) -> Vec<T> {
        match self.torques {
            Torques::Held(tau) => tau[first * nv..][..states * nv].to_vec(),
            _ => vec![T::zero(); states * nv],
        }
    }

    /// Torques of some steps, \[steps\]\[states\]\[nv\], from \[batch\]\[steps\]\[nv\].
    fn torques_by_step(
        &self,
        tau: &[T],
        first: usize,
        states: usize,
        steps: core::ops::Range<usize>,
        nv: usize,
    ) -> Vec<T> {
        let row =
            |step: usize, state: usize| &tau[((first + state) * self.rollout.steps + step) * nv..][..nv];
        steps.flat_map(|step| (0..states).flat_map(move |state| row(step, state))).copied().collect()
    }
}
