//! The loop of an adaptive run: steps, samples, events, control instants.

use std::ops::ControlFlow;

use robot_dynamics_core::algorithms::energy::energies;
use robot_dynamics_core::{Model, Workspace, check_rank};

use super::super::divergence::{GROWN, LOST};
use super::super::energy_account::fastest;
use super::super::event::EventDetector;
use super::super::results::Observer;
use super::super::{Controller, Run, RunError, StepError, Stepper};
use super::motion::{AdaptiveSystem, ExternalInputs, MotionFailure};
use super::stepper::{AdvanceResult, StepSequence};
use super::{AdaptiveStepper, ControlTiming};

/// An adaptive run. Its samples lie on a uniform grid; the steps between them are as long as the tolerance
/// allows.
pub struct AdaptiveRun<'r, 'o> {
    pub model: &'r Model,
    pub stepper: &'r mut AdaptiveStepper,
    pub workspace: &'r mut Workspace,
    pub run: &'r mut Run,
    /// Whether the joints' damping acts.
    pub dissipation: bool,
    /// The number of instants between samples. The first and the last are always kept; with 0 no others are.
    pub sample_every: usize,
    pub(crate) observer: Option<Observer<'o>>,
    /// The number of instants at which the torque of each coordinate was clipped.
    pub limited: &'r mut [usize],
    /// The torques at the last sample, after effort limits.
    pub tau: &'r mut [f64],
    /// The acceleration at the end.
    pub acceleration: &'r mut [f64],
}

impl AdaptiveRun<'_, '_> {
    /// Advances over a number of instants, or until the run ends early. `time` gives the time of an instant,
    /// counted from the current one.
    pub fn follow(
        &mut self,
        instants: usize,
        time_of: &dyn Fn(usize) -> f64,
        applied: ExternalInputs<'_>,
        detector: &mut EventDetector<'_, '_>,
    ) -> Result<(), RunError> {
        let model = self.model;
        let (start, end) = (self.run.time, time_of(instants));
        self.check_mass(start, &self.run.q.clone())?;
        self.stepper.choose(model, self.workspace, (&self.run.q, &self.run.v), self.dissipation);
        let motion = AdaptiveSystem::new(model, self.dissipation, self.stepper.energy, applied);
        let mut held = None;
        if let ControlTiming::Held { period } = self.stepper.options.control
            && let Some(controller) = motion.take_controller()
        {
            let tau = vec![0.0; model.nv()];
            let held = held.insert(HeldControl { controller, period, next: 0, start, tau });
            held.update(&motion, model, self.run.steps, (&self.run.q, &self.run.v))?;
        }
        let y: Vec<f64> =
            [&self.run.q[..], &self.run.v, self.stepper.controller_states(), &[0.0, 0.0]].concat();
        let account = [self.run.energy_account.work(), self.run.energy_account.dissipated()];
        let mut samples = Samples { first: self.run.steps, seen: 0, account, is_started: false };
        let flow = self.sample(&motion, &mut samples, (0, start), &y, instants == 0)?;
        if instants == 0 {
            self.run.interrupted = false;
        }
        if instants == 0 || flow.is_break() {
            return Ok(());
        }
        let step = self.run.steps;
        let mut steps = StepSequence::start(
            self.stepper.record.method,
            &self.stepper.options,
            self.stepper.wanted,
            &motion,
            (start, end),
            &y,
        )
        .map_err(|failure| failure.at(model, start, step))?;
        let grid = SampleGrid::new(instants, time_of, self.observer.is_some(), self.sample_every);
        let done = self.take_steps(&mut steps, &motion, held, grid, (detector, &mut samples));
        self.stepper.record.statistics.add(&steps.statistics);
        self.stepper.wanted = steps.wanted();
        if done.is_ok() {
            motion.acceleration(steps.t, steps.y(), self.acceleration);
        }
        done
    }

    /// Takes steps until the last instant, or until the run ends early.
    fn take_steps(
        &mut self,
        steps: &mut StepSequence,
        motion: &AdaptiveSystem<'_, '_>,
        mut held: Option<HeldControl<'_>>,
        mut grid: SampleGrid<'_>,
        (detector, samples): (&mut EventDetector<'_, '_>, &mut Samples),
    ) -> Result<(), RunError> {
        let model = self.model;
        loop {
            let target = held.as_ref().map_or(grid.end(), |held| held.instant().min(grid.end()));
            if self.step_towards(target, steps, motion, samples)?.is_break()
                || self.record_step(steps, motion, &mut grid, (detector, samples))?.is_break()
            {
                return Ok(());
            }
            if let Err(singular) = self.check_mass(steps.t, &steps.y()[..model.nq()]) {
                let _ = self.sample(motion, samples, (samples.seen + 1, steps.t), steps.y(), true)?;
                return Err(singular);
            }
            if let Some(held) = held.as_mut().filter(|held| steps.t >= held.instant()) {
                let (mut q, mut v) = (Vec::new(), Vec::new());
                motion.split(steps.y(), &mut q, &mut v);
                held.update(motion, model, self.run.steps, (&q, &v))?;
                steps.restart(motion).map_err(|failure| failure.at(model, steps.t, self.run.steps))?;
                steps.since = 0;
            }
        }
    }

    /// Takes one step, at most to `target`; breaks if it is interrupted. After an interruption or an error,
    /// the state of the last accepted step is the last sample.
    fn step_towards(
        &mut self,
        target: f64,
        steps: &mut StepSequence,
        motion: &AdaptiveSystem<'_, '_>,
        samples: &mut Samples,
    ) -> Result<ControlFlow<()>, RunError> {
        match steps.advance(motion, target, self.stepper.interrupt.as_deref()) {
            Ok(AdvanceResult::Moved) => {}
            Ok(AdvanceResult::Interrupted) => {
                self.sample_rest(steps, motion, samples);
                self.run.interrupted = true;
                return Ok(ControlFlow::Break(()));
            }
            Err(failure) => {
                self.sample_rest(steps, motion, samples);
                return Err(self.cause_of(failure, steps));
            }
        }
        self.stepper.note_quaternions(self.model, steps.y());
        if let Err(grown) = self.check_growth(steps, LOST) {
            self.sample_rest(steps, motion, samples);
            return Err(grown);
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The error of a run whose step failed: a singular M or divergence, which cause other failures, or else
    /// the failure itself.
    fn cause_of(&mut self, failure: MotionFailure, steps: &StepSequence) -> RunError {
        let model = self.model;
        if let Err(singular) = self.check_mass(steps.t, &steps.y()[..model.nq()]) {
            return singular;
        }
        if steps.statistics.accepted > 0
            && !matches!(failure, MotionFailure::Controller(_))
            && let Err(grown) = self.check_growth(steps, GROWN)
        {
            return grown;
        }
        failure.at(model, steps.t, self.run.steps)
    }

    /// Records the events and the samples of the last step; breaks if the run ends there.
    fn record_step(
        &mut self,
        steps: &mut StepSequence,
        motion: &AdaptiveSystem<'_, '_>,
        grid: &mut SampleGrid<'_>,
        (detector, samples): (&mut EventDetector<'_, '_>, &mut Samples),
    ) -> Result<ControlFlow<()>, RunError> {
        let (from, to) = (steps.from, steps.t);
        let mut found =
            detector.find_crossings(from, to, &mut |t, q, v| motion.split(&steps.interpolate(t), q, v))?;
        let terminal = found.iter().position(|found| found.is_terminal);
        let stop = terminal.map(|index| found[index].occurrence.time);
        while let Some((instant, time)) = grid.due(to, stop) {
            if self.sample(motion, samples, (instant, time), &steps.interpolate(time), false)?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
            grid.advance();
            steps.since = 0;
        }
        found.truncate(terminal.map_or(found.len(), |index| index + 1));
        self.run.events.extend(found.into_iter().map(|found| found.occurrence));
        if let Some(time) = stop {
            let _ = self.sample(motion, samples, (samples.seen + 1, time), &steps.interpolate(time), true)?;
            (self.run.ended_by_event, self.run.interrupted) = (true, false);
            return Ok(ControlFlow::Break(()));
        }
        if to >= grid.end() {
            let _ = self.sample(motion, samples, (grid.instants, grid.end()), steps.y(), true)?;
            self.run.interrupted = false;
            return Ok(ControlFlow::Break(()));
        }
        Ok(ControlFlow::Continue(()))
    }

    /// # Errors
    /// [`StepError::Diverged`] if a coordinate moved by more than `most` in the last step \[rad or
    /// m\].
    fn check_growth(&self, steps: &StepSequence, most: f64) -> Result<(), RunError> {
        let model = self.model;
        let v = &steps.y()[model.nq()..model.nq() + model.nv()];
        let Some(&speed) = v.get(fastest(v)) else { return Ok(()) };
        let step = steps.t - steps.from;
        if speed.abs() * step <= most {
            return Ok(());
        }
        let coordinate = model.coordinate_names().get(fastest(v)).cloned().unwrap_or_default();
        let source = StepError::Diverged { coordinate, speed, step };
        Err(RunError::Step { step: self.run.steps, time: steps.t, source })
    }

    /// Adds a last sample at the current state, if it is later than the sample before.
    fn sample_rest(&mut self, steps: &StepSequence, motion: &AdaptiveSystem<'_, '_>, samples: &mut Samples) {
        if steps.t > self.run.time {
            let _ = self.sample(motion, samples, (samples.seen + 1, steps.t), steps.y(), true);
        }
    }

    /// Records the state y at `time`, and calls the observer.
    ///
    /// # Errors
    /// [`RunError::Controller`] or [`RunError::StepInput`] if the torque is missing or invalid,
    /// [`RunError::NotFinite`] if the energy is not finite; nothing is recorded then.
    fn sample(
        &mut self,
        motion: &AdaptiveSystem<'_, '_>,
        samples: &mut Samples,
        (instant, time): (usize, f64),
        y: &[f64],
        is_last: bool,
    ) -> Result<ControlFlow<()>, RunError> {
        let (model, run) = (self.model, &mut *self.run);
        let tau = &mut *self.tau;
        let (mut q, mut v) = (Vec::new(), Vec::new());
        motion.split(y, &mut q, &mut v);
        let step = run.steps;
        let failed = |failure: MotionFailure| failure.at(model, time, step);
        motion.torque(time, &q, &v, tau).map_err(failed)?;
        let (kinetic, potential) = energies(model, self.workspace, &q, &v);
        if let Some(driven) = &mut self.stepper.driven {
            driven.set_states(y);
        }
        let potential = potential + self.stepper.drive(model, (time, &q, &v));
        let [work, dissipated] = [y[y.len() - 2], y[y.len() - 1]].map(|account| motion.energy * account);
        if !(kinetic + potential - work + dissipated).is_finite() {
            return Err(failed(MotionFailure::NotFinite("the energy", fastest(&v))));
        }
        (run.q, run.v) = (q, v);
        run.energy_account.enter(
            kinetic,
            potential,
            samples.account[0] + work,
            samples.account[1] + dissipated,
        );
        let by_actuators = self.stepper.actuator_torques();
        for (k, peak) in run.peak_torque.iter_mut().enumerate() {
            *peak = peak.max((tau[k] + by_actuators.get(k).unwrap_or(&0.0)).abs());
        }
        run.time = time;
        run.steps = samples.first + instant;
        samples.seen = instant;
        let info = run.step_info(instant, tau, &*self.stepper);
        let flow = self.observer.as_mut().map_or(ControlFlow::Continue(()), |observer| observer(&info));
        let is_first = !core::mem::replace(&mut samples.is_started, true);
        let is_in_step = self.sample_every > 0 && instant.is_multiple_of(self.sample_every);
        let is_kept = is_in_step || is_first || is_last || flow.is_break();
        if !is_last && !flow.is_break() {
            motion.count_limited(self.limited);
        }
        if is_kept {
            run.keep_sample(tau, &*self.stepper);
            run.trajectory.add_to_last_tau(by_actuators);
        }
        run.interrupted = flow.is_break();
        Ok(flow)
    }

    /// Checks that M is regular at q.
    fn check_mass(&mut self, time: f64, q: &[f64]) -> Result<(), RunError> {
        let step = self.run.steps;
        check_rank(self.model, self.workspace, q).map_err(|source| RunError::SingularMass {
            step,
            time,
            source,
        })
    }
}

/// The progress of the samples.
struct Samples {
    /// The number of the simulation's steps before the run.
    first: usize,
    /// The instant of the last sample.
    seen: usize,
    /// Work and dissipation before the last sample \[J\].
    account: [f64; 2],
    is_started: bool,
}

/// The instants of a run at which samples are evaluated between its first and last instant.
struct SampleGrid<'t> {
    /// The number of the last instant.
    instants: usize,
    time_of: &'t dyn Fn(usize) -> f64,
    stride: usize,
    /// The next instant.
    next: usize,
}

impl<'t> SampleGrid<'t> {
    /// An observer needs a sample at every instant; without one, only the kept samples are evaluated.
    fn new(
        instants: usize,
        time_of: &'t dyn Fn(usize) -> f64,
        is_observed: bool,
        sample_every: usize,
    ) -> Self {
        let stride = match (is_observed, sample_every) {
            (true, _) => 1,
            (false, 0) => instants,
            (false, every) => every,
        };
        Self { instants, time_of, stride, next: stride.min(instants) }
    }

    /// The time of the last instant.
    fn end(&self) -> f64 {
        (self.time_of)(self.instants)
    }

    /// The next instant and its time, if it is not after `to`, before `stop`, and not the last instant.
    fn due(&self, to: f64, stop: Option<f64>) -> Option<(usize, f64)> {
        let time = (self.time_of)(self.next);
        let is_due = time <= to && stop.is_none_or(|stop| time < stop) && self.next < self.instants;
        is_due.then_some((self.next, time))
    }

    /// Passes to the next instant.
    fn advance(&mut self) {
        self.next = (self.next + self.stride).min(self.instants);
    }
}

/// A controller that is called once a period.
struct HeldControl<'c> {
    controller: &'c mut dyn Controller,
    period: f64,
    /// The number of the next instant.
    next: u64,
    start: f64,
    /// The torques of the last call.
    tau: Vec<f64>,
}

impl HeldControl<'_> {
    /// The next control instant \[s\].
    fn instant(&self) -> f64 {
        self.start + self.next as f64 * self.period
    }

    /// Calls the controller at this state, and holds its torques until the next instant. `step` is the number
    /// of the last sample, for errors.
    fn update(
        &mut self,
        motion: &AdaptiveSystem<'_, '_>,
        model: &Model,
        step: usize,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), RunError> {
        let (time, tau) = (self.instant(), &mut self.tau);
        self.controller.torque(time, q, v, tau).map_err(|source| RunError::Controller {
            step,
            time,
            source,
        })?;
        self.next += 1;
        if let Some(failure) = MotionFailure::of_torque(model, tau) {
            return Err(failure.at(model, time, step));
        }
        motion.set_torques(tau);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::SampleGrid;

    /// The instants that are sampled between the first and the last one, up to `to` and before `stop`.
    fn sampled(is_observed: bool, sample_every: usize, to: f64, stop: Option<f64>) -> Vec<usize> {
        let time_of = |instant: usize| instant as f64 * 0.1;
        let mut grid = SampleGrid::new(7, &time_of, is_observed, sample_every);
        let mut all = Vec::new();
        while let Some((instant, time)) = grid.due(to, stop) {
            assert!(time.to_bits() == time_of(instant).to_bits());
            all.push(instant);
            grid.advance();
        }
        all
    }

    #[test]
    fn samples_lie_between_the_ends() {
        assert_eq!(sampled(true, 3, 1.0, None), [1, 2, 3, 4, 5, 6]);
        assert_eq!(sampled(false, 3, 1.0, None), [3, 6]);
        assert_eq!(sampled(false, 0, 1.0, None), [0; 0]);
        assert_eq!(sampled(false, 9, 1.0, None), [0; 0]);
        assert_eq!(sampled(true, 1, 0.25, None), [1, 2]);
        assert_eq!(sampled(true, 1, 1.0, Some(0.1)), [0; 0]);
    }
}
