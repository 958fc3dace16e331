//! Motion in time: the states stay on the device, which takes one step after the other.

use dynamics::Integrator;
use generate::Function;
use multibody::Rollout;
use multibody::batch::{BadStates, RolloutError, RolloutProgress, Torques};

use crate::backend::{Backend, Command};
use crate::machine::{Machine, Motion, Progress, check_table};
use crate::robot::{note_not_finite, noted};
use crate::{DeviceError, DeviceFloat};

/// Steps between two looks at the progress callback.
const STEPS_PER_LOOK: usize = 64;

/// The function that is one step of a row.
fn step_of(integrator: Integrator) -> Option<Function> {
    match integrator {
        Integrator::SemiImplicitEuler => Some(Function::SemiImplicitEulerStep),
        Integrator::RungeKutta4 => Some(Function::Rk4Step),
        _ => None,
    }
}

/// Tables of a rollout on the device. The state goes to and fro between two.
#[derive(Clone, Copy)]
enum At {
    Q0,
    V0,
    Q1,
    V1,
    Tau,
    H,
    /// Torques of a stretch of steps: \[steps\]\[states\]\[nv\].
    EachTau,
    /// Samples of a stretch of steps: \[samples\]\[states\]\[nq\] and \[nv\].
    QSamples,
    VSamples,
}

/// What a rollout is, and how it goes through the device.
struct Course<'a, T> {
    rollout: &'a Rollout,
    torques: Torques<'a, T>,
    /// States at once.
    most: usize,
    /// Steps at once.
    stretch: usize,
}

impl<B: Backend, T: DeviceFloat> Machine<B, T> {
    /// See [`Batches::rollout`](crate::Batches::rollout).
    #[track_caller]
    pub(crate) fn move_states(
        &mut self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        motion: Motion<'_, T>,
        progress: Progress<'_>,
    ) -> Result<(), DeviceError> {
        let (nq, nv) = (self.robot.nq, self.robot.nv);
        let h = T::from_f64(rollout.step);
        if !(h.is_finite() && h > T::zero()) {
            return Err(RolloutError::BadStep { step: rollout.step }.into());
        }
        let function =
            step_of(rollout.integrator).ok_or(DeviceError::NoStep { integrator: rollout.integrator })?;
        let at = self.find(&function)?;
        if !rollout.dissipation && self.robot.dissipates {
            return Err(DeviceError::Dissipation { robot: self.robot.name.clone() });
        }
        let batch = self.check_tables(rollout, torques, &motion)?;
        let tau = match torques {
            Torques::Held(tau) | Torques::EachStep(tau) => tau,
            Torques::Zero | Torques::Policy(_) => &[],
        };
        let mut bad: Vec<usize> = noted(&self.bad_states_of([motion.q, motion.v, tau]), 0).collect();
        if batch == 0 || rollout.steps == 0 {
            return Ok(BadStates::unless_empty(bad, batch)?);
        }
        let most = self.states_at_once(&function, nq.max(nv))?.min(batch);
        let fits = self.backend.most_bytes() / (most * nq.max(nv) * size_of::<T>());
        let stretch = STEPS_PER_LOOK.min(fits.max(1)).min(rollout.steps);
        let course = Course { rollout, torques, most, stretch };
        self.make_room(&course.sizes(nq, nv))?;
        self.backend.write(self.buffer(At::H as usize), bytemuck::cast_slice(&vec![h; most]))?;

        let Motion { q, v, trajectory: (q_trajectory, v_trajectory) } = motion;
        let samples = rollout.samples();
        let total = batch as u64 * rollout.steps as u64;
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
            let is_finished = self.advance(at, &course, (first, states), (q, v), trajectory, &mut go_on)?;
            let end = if is_finished { first + states } else { first };
            if is_cancelled && end < batch {
                return Err(RolloutError::Cancelled { unfinished: (end..batch).collect(), batch }.into());
            }
            bad.extend(noted(&self.bad_states_of([q, v, &[]]), first));
        }
        let bad = BadStates::unless_empty(bad, batch);
        if let Err(BadStates { states, .. }) = &bad {
            for state in states {
                q[state * nq..][..nq].fill(T::NAN);
                v[state * nv..][..nv].fill(T::NAN);
            }
        }
        Ok(bad?)
    }

    /// How many states; panics with both numbers where a table has another length.
    #[track_caller]
    fn check_tables(
        &self,
        rollout: &Rollout,
        torques: Torques<'_, T>,
        motion: &Motion<'_, T>,
    ) -> Result<usize, DeviceError> {
        let (nq, nv) = (self.robot.nq, self.robot.nv);
        let len = motion.q.len();
        assert!(len.is_multiple_of(nq), "q has {len} numbers, not a multiple of nq = {nq}");
        let batch = len / nq;
        check_table("v", motion.v.len(), batch, nv);
        check_table("the trajectory of q", motion.trajectory.0.len(), batch, rollout.samples() * nq);
        check_table("the trajectory of v", motion.trajectory.1.len(), batch, rollout.samples() * nv);
        match torques {
            Torques::Zero => {}
            Torques::Held(tau) => check_table("tau", tau.len(), batch, nv),
            Torques::EachStep(tau) => check_table("tau", tau.len(), batch, rollout.steps * nv),
            Torques::Policy(_) => return Err(DeviceError::Policy),
        }
        Ok(batch)
    }

    /// Which states have a number in q, v or τ that is not finite, or a q that is no configuration.
    fn bad_states_of(&self, [q, v, tau]: [&[T]; 3]) -> Vec<bool> {
        let mut is_bad = vec![false; q.len() / self.robot.nq];
        for rows in [q, v, tau] {
            note_not_finite(rows, &mut is_bad);
        }
        self.robot.note_without_value(q, &mut is_bad);
        is_bad
    }

    /// Some states from start to end; whether they have come to it, or are as they were since `go_on` said no.
    fn advance(
        &self,
        at: usize,
        course: &Course<'_, T>,
        (first, states): (usize, usize),
        (q, v): (&mut [T], &mut [T]),
        (q_trajectory, v_trajectory): (&mut [T], &mut [T]),
        go_on: &mut dyn FnMut(usize) -> bool,
    ) -> Result<bool, DeviceError> {
        let (nq, nv, size) = (self.robot.nq, self.robot.nv, size_of::<T>());
        let (rollout, backend) = (course.rollout, &*self.backend);
        let buffer = |table: At| self.buffer(table as usize);
        backend.write(buffer(At::Q0), bytemuck::cast_slice(q))?;
        backend.write(buffer(At::V0), bytemuck::cast_slice(v))?;
        let start = course.start_torques(first, states, nv);
        backend.write(buffer(At::Tau), bytemuck::cast_slice(&start))?;
        let to_and_fro = [[At::Q0, At::V0, At::Q1, At::V1], [At::Q1, At::V1, At::Q0, At::V0]];
        let launches = to_and_fro.map(|[q, v, q_next, v_next]| {
            let widths = [(q, nq), (v, nv), (At::Tau, nv), (At::H, 1), (q_next, nq), (v_next, nv)];
            let tables = widths.map(|(table, width)| (buffer(table), width * size));
            backend.bind(&self.function(at).kernel, &tables, states)
        });
        let samples = rollout.samples();
        let mut taken = 0;
        while taken < rollout.steps {
            let steps = course.stretch.min(rollout.steps - taken);
            if let Torques::EachStep(tau) = course.torques {
                let rows = course.torques_by_step(tau, first, states, taken..taken + steps, nv);
                backend.write(buffer(At::EachTau), bytemuck::cast_slice(&rows))?;
            }
            let (mut commands, mut sampled) = (Vec::new(), 0);
            for step in 0..steps {
                if matches!(course.torques, Torques::EachStep(_)) {
                    let bytes = states * nv * size;
                    let (from, to) = (buffer(At::EachTau), buffer(At::Tau));
                    commands.push(Command::Copy { from, from_at: step * bytes, to, to_at: 0, bytes });
                }
                let side = (taken + step) % 2;
                commands.push(Command::Run(&launches[side]));
                if rollout.stride != 0 && (taken + step + 1).is_multiple_of(rollout.stride) {
                    let [.., q_next, v_next] = to_and_fro[side];
                    for (from, to, width) in [(q_next, At::QSamples, nq), (v_next, At::VSamples, nv)] {
                        let bytes = states * width * size;
                        let (from, to) = (buffer(from), buffer(to));
                        commands.push(Command::Copy { from, from_at: 0, to, to_at: sampled * bytes, bytes });
                    }
                    sampled += 1;
                }
            }
            backend.submit(&commands)?;
            if sampled > 0 {
                let before = taken / rollout.stride;
                for (table, rows, width) in
                    [(At::QSamples, &mut *q_trajectory, nq), (At::VSamples, &mut *v_trajectory, nv)]
                {
                    let mut found = vec![T::zero(); sampled * states * width];
                    backend.read(buffer(table), bytemuck::cast_slice_mut(&mut found))?;
                    for (k, found) in found.chunks(width).enumerate() {
                        let (sample, state) = (before + k / states, k % states);
                        rows[(state * samples + sample) * width..][..width].copy_from_slice(found);
                    }
                }
            } else {
                backend.wait()?;
            }
            taken += steps;
            if !go_on(steps) && taken < rollout.steps {
                return Ok(false);
            }
        }
        let [.., q_end, v_end] = to_and_fro[(rollout.steps - 1) % 2];
        backend.read(buffer(q_end), bytemuck::cast_slice_mut(q))?;
        backend.read(buffer(v_end), bytemuck::cast_slice_mut(v))?;
        Ok(true)
    }
}

impl<T: DeviceFloat> Course<'_, T> {
    /// Numbers of each table, in the order of [`At`].
    fn sizes(&self, nq: usize, nv: usize) -> Vec<usize> {
        let of_steps =
            |is_there: bool, width: usize| if is_there { self.most * self.stretch * width } else { 1 };
        let is_each = matches!(self.torques, Torques::EachStep(_));
        let is_sampled = self.rollout.stride != 0;
        let state = [nq, nv, nq, nv, nv, 1].map(|width| width * self.most);
        let stretch = [of_steps(is_each, nv), of_steps(is_sampled, nq), of_steps(is_sampled, nv)];
        state.into_iter().chain(stretch).collect()
    }

    /// Torques that are held, or none.
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
