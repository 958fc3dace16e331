//! The loop of an adaptive run: steps, samples, events, control instants.

use std::ops::ControlFlow;

use robot_dynamics_core::algorithms::energy::energies;
use robot_dynamics_core::{Model, Workspace, check_rank};

use super::super::divergence::{GROWN, LOST};
use super::super::event::EventDetector;
use super::super::ledger::fastest;
use super::super::results::Observer;
use super::super::{Controller, Run, RunError, StepError, Stepper};
use super::motion::{ExternalInputs, Motion, MotionFailure};
use super::stepper::{Advance, StepSequence};
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
        watch: &mut EventDetector<'_, '_>,
    ) -> Result<(), RunError> {
        let model = self.model;
        let (start, end) = (self.run.time, time_of(instants));
        self.check_mass(start, &self.run.q.clone())?;
        self.stepper.choose(model, self.workspace, (&self.run.q, &self.run.v), self.dissipation);
        let motion = Motion::new(model, self.dissipation, self.stepper.energy, applied);
        let mut held = None;
        if let ControlTiming::Held { period } = self.stepper.options.control
            && let Some(controller) = motion.take_controller()
        {
            held = Some(HeldControl { controller, period, next: 0, start });
        }
        let mut tau = vec![0.0; model.nv()];
        if let Some(held) = &mut held {
            held.ask(self.run, &mut tau, model, None)?;
            motion.hold(&tau);
        }
        let y: Vec<f64> = [&self.run.q[..], &self.run.v, &[0.0, 0.0]].concat();
        let account = [self.run.ledger.work(), self.run.ledger.dissipated()];
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
        let done = self.take(&mut steps, &motion, (instants, time_of), (held, tau), (watch, &mut samples));
        self.stepper.record.statistics.add(&steps.statistics);
        self.stepper.wanted = steps.wanted();
        if done.is_ok() {
            motion.acceleration(steps.t, steps.y(), self.acceleration);
        }
        done
    }

    fn take(
        &mut self,
        steps: &mut StepSequence,
        motion: &Motion<'_, '_>,
        (instants, time_of): (usize, &dyn Fn(usize) -> f64),
        (mut held, mut tau): (Option<HeldControl<'_>>, Vec<f64>),
        (watch, samples): (&mut EventDetector<'_, '_>, &mut Samples),
    ) -> Result<(), RunError> {
        let model = self.model;
        let end = time_of(instants);
        // An observer needs a sample at every instant; without one, only the kept samples are evaluated.
        let stride = match (&self.observer, self.sample_every) {
            (Some(_), _) => 1,
            (None, 0) => instants,
            (None, every) => every,
        };
        let mut next = stride.min(instants);
        loop {
            let target = held.as_ref().map_or(end, |held| held.instant().min(end));
            match steps.advance(motion, target, self.stepper.interrupt.as_deref()) {
                Ok(Advance::Moved) => {}
                Ok(Advance::Interrupted) => {
                    // Keep the results of the steps since the last sample.
                    self.sample_rest(steps, motion, samples);
                    self.run.interrupted = true;
                    return Ok(());
                }
                Err(failure) => {
                    self.sample_rest(steps, motion, samples);
                    // If M is singular, report that instead of the step's error.
                    self.check_mass(steps.t, &steps.y()[..model.nq()])?;
                    if steps.statistics.accepted > 0 && !matches!(failure, MotionFailure::Controller(_)) {
                        self.check_growth(steps, GROWN)?;
                    }
                    return Err(failure.at(model, steps.t, self.run.steps));
                }
            }
            self.stepper.note_quaternions(model, steps.y());

            let (from, to) = (steps.from, steps.t);
            if let Err(grown) = self.check_growth(steps, LOST) {
                self.sample_rest(steps, motion, samples);
                return Err(grown);
            }
            let found = watch.look(from, to, &mut |t, q, v| motion.split(&steps.interpolate(t), q, v))?;
            let last = found.iter().position(|found| found.is_terminal);
            let stop = last.map(|index| found[index].occurrence.time);
            while time_of(next) <= to && stop.is_none_or(|stop| time_of(next) < stop) && next < instants {
                let time = time_of(next);
                if self.sample(motion, samples, (next, time), &steps.interpolate(time), false)?.is_break() {
                    return Ok(());
                }
                next = (next + stride).min(instants);
                steps.since = 0;
            }
            let kept = last.map_or(found.len(), |index| index + 1);
            self.run.events.extend(found.into_iter().take(kept).map(|found| found.occurrence));
            if let Some(time) = stop {
                let _ =
                    self.sample(motion, samples, (samples.seen + 1, time), &steps.interpolate(time), true)?;
                (self.run.ended_by_event, self.run.interrupted) = (true, false);
                return Ok(());
            }
            if to >= end {
                let _ = self.sample(motion, samples, (instants, end), steps.y(), true)?;
                self.run.interrupted = false;
                return Ok(());
            }
            if let Err(singular) = self.check_mass(to, &steps.y()[..model.nq()]) {
                let _ = self.sample(motion, samples, (samples.seen + 1, to), steps.y(), true)?;
                return Err(singular);
            }
            if let Some(held) = held.as_mut().filter(|held| to >= held.instant()) {
                let (mut q, mut v) = (Vec::new(), Vec::new());
                motion.split(steps.y(), &mut q, &mut v);
                held.ask(self.run, &mut tau, model, Some((&q, &v)))?;
                motion.hold(&tau);
                steps.restart(motion).map_err(|failure| failure.at(model, steps.t, self.run.steps))?;
                steps.since = 0;
            }
        }
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
    fn sample_rest(&mut self, steps: &StepSequence, motion: &Motion<'_, '_>, samples: &mut Samples) {
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
        motion: &Motion<'_, '_>,
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
        let potential = potential + self.stepper.drive(model, (time, &q, &v));
        let [work, dissipated] = [y[y.len() - 2], y[y.len() - 1]].map(|account| motion.energy * account);
        if !(kinetic + potential - work + dissipated).is_finite() {
            return Err(failed(MotionFailure::NotFinite("the energy", fastest(&v))));
        }
        (run.q, run.v) = (q, v);
        run.ledger.enter(kinetic, potential, samples.account[0] + work, samples.account[1] + dissipated);
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

/// A controller that is called once a period.
struct HeldControl<'c> {
    controller: &'c mut dyn Controller,
    period: f64,
    /// The number of the next instant.
    next: u64,
    start: f64,
}

impl HeldControl<'_> {
    /// The next control instant \[s\].
    fn instant(&self) -> f64 {
        self.start + self.next as f64 * self.period
    }

    /// Calls the controller at this state, or at that of the run.
    fn ask(
        &mut self,
        run: &Run,
        tau: &mut [f64],
        model: &Model,
        state: Option<(&[f64], &[f64])>,
    ) -> Result<(), RunError> {
        let (time, step) = (self.instant(), run.steps);
        let (q, v) = state.unwrap_or((&run.q, &run.v));
        self.controller.torque(time, q, v, tau).map_err(|source| RunError::Controller {
            step,
            time,
            source,
        })?;
        self.next += 1;
        MotionFailure::of_torque(model, tau).map_or(Ok(()), |failure| Err(failure.at(model, time, step)))
    }
}
