//! The course of an adaptive run: steps, samples, events, control instants.

use std::ops::ControlFlow;

use super::super::divergence::{GROWN, LOST};
use super::super::event::{Event, Watch};
use super::super::ledger::fastest;
use super::error::AdaptiveError;
use super::method::AdaptiveMethod;
use super::motion::{Motion, TORQUE, Trouble};
use super::stepper::{Advance, Stepper};
use super::{AdaptiveEnd, AdaptiveRun, AdaptiveSimulation, ControlTiming};
use crate::algorithms::energy::energies;
use crate::algorithms::rank::check_rank;
use crate::{Controller, Model, Moment, Workspace};

/// A run under way.
pub(super) struct Course<'r, 'a, O> {
    pub simulation: &'r AdaptiveSimulation<'a>,
    pub workspace: Workspace,
    pub run: &'r mut AdaptiveRun,
    /// Samples shown.
    pub samples: usize,
    pub observer: &'r mut O,
}

impl<O: FnMut(&Moment<'_>) -> ControlFlow<()>> Course<'_, '_, O> {
    /// From the first time to the last, or to what ends it.
    pub(super) fn follow(
        &mut self,
        (start, end): (f64, f64),
        between: &mut impl Iterator<Item = f64>,
        controller: &mut dyn Controller,
        events: &mut [Event<'_>],
    ) -> Result<(), AdaptiveError> {
        let AdaptiveSimulation { model, dissipation, control, .. } = *self.simulation;
        if !(start.is_finite() && end.is_finite() && start < end) {
            return Err(AdaptiveError::Times { index: 1, time: end, before: start });
        }
        let q = self.run.q.clone();
        self.check_mass(start, &q)?;
        self.run.method = self.simulation.method.chosen(model, &mut self.workspace, &q, dissipation);
        let energy = if self.run.method == AdaptiveMethod::Implicit {
            1.0 + self.run.ledger.start().abs()
        } else {
            1.0
        };
        let motion = Motion::new(model, dissipation, energy);
        let mut held = None;
        match control {
            ControlTiming::Continuous => motion.control(controller),
            ControlTiming::Held { period } => held = Some(HeldControl { controller, period, next: 0, start }),
        }
        let mut tau = vec![0.0; model.nv()];
        if let Some(held) = &mut held {
            held.ask(&self.run.q, &self.run.v, &mut tau, model)?;
            motion.hold(&tau);
        }
        let y: Vec<f64> = [&self.run.q[..], &self.run.v, &[0.0, 0.0]].concat();
        let mut watch = Watch::start(events, start, &self.run.q, &self.run.v)?;
        if self.sample(&motion, start, &y, false)?.is_break() {
            return Ok(());
        }
        let mut stepper = Stepper::start(self.run.method, self.simulation, &motion, (start, end), &y)?;
        let mut count = 1;
        let mut sample = next_time(between, &mut count, start, end)?;
        loop {
            let target = held.as_ref().map_or(end, |held| held.instant().min(end));
            let advanced = stepper.advance(&motion, target);
            self.run.statistics = stepper.statistics;
            if advanced != Ok(Advance::Moved) {
                // What the steps since the last sample came to is not lost.
                if stepper.t > self.run.time {
                    let _ = self.sample(&motion, stepper.t, stepper.y(), true);
                }
                if advanced.is_err() {
                    // Where M is singular the reason is that, whatever stopped the step.
                    self.check_mass(stepper.t, &stepper.y()[..model.nq()])?;
                    if stepper.statistics.accepted > 0
                        && !matches!(advanced, Err(AdaptiveError::Controller { .. }))
                    {
                        self.check_growth((stepper.from, stepper.t), stepper.y(), GROWN)?;
                    }
                }
                advanced?;
                self.run.end = AdaptiveEnd::Interrupted;
                return Ok(());
            }
            self.note_quaternions(stepper.y());

            let (from, to) = (stepper.from, stepper.t);
            if let Err(grown) = self.check_growth((from, to), stepper.y(), LOST) {
                let _ = self.sample(&motion, to, stepper.y(), true);
                return Err(grown);
            }
            let found = watch.look(from, to, &mut |t, q, v| motion.split(&stepper.interpolate(t), q, v))?;
            let last = found.iter().position(|found| found.is_terminal);
            let stop = last.map(|index| found[index].occurrence.time);
            while sample <= to && stop.is_none_or(|stop| sample < stop) && sample < end {
                if self.sample(&motion, sample, &stepper.interpolate(sample), false)?.is_break() {
                    return Ok(());
                }
                sample = next_time(between, &mut count, sample, end)?;
                stepper.since = 0;
            }
            let kept = last.map_or(found.len(), |index| index + 1);
            self.run.events.extend(found.into_iter().take(kept).map(|found| found.occurrence));
            if let Some(time) = stop {
                let _ = self.sample(&motion, time, &stepper.interpolate(time), true)?;
                self.run.end = AdaptiveEnd::Event;
                return Ok(());
            }
            if to >= end {
                let _ = self.sample(&motion, end, stepper.y(), true)?;
                self.run.end = AdaptiveEnd::Finished;
                return Ok(());
            }
            if let Err(singular) = self.check_mass(to, &stepper.y()[..model.nq()]) {
                let _ = self.sample(&motion, to, stepper.y(), true)?;
                return Err(singular);
            }
            if let Some(held) = held.as_mut().filter(|held| to >= held.instant()) {
                let (mut q, mut v) = (Vec::new(), Vec::new());
                motion.split(stepper.y(), &mut q, &mut v);
                held.ask(&q, &v, &mut tau, model)?;
                motion.hold(&tau);
                stepper.restart(&motion)?;
                stepper.since = 0;
            }
        }
    }

    /// # Errors
    /// [`AdaptiveError::Diverged`]: in the last step a coordinate has moved by more than this \[rad or m\].
    fn check_growth(&self, (from, to): (f64, f64), y: &[f64], most: f64) -> Result<(), AdaptiveError> {
        let model = self.simulation.model;
        let v = &y[model.nq()..model.nq() + model.nv()];
        let Some(&speed) = v.get(fastest(v)) else { return Ok(()) };
        let step = to - from;
        if speed.abs() * step <= most {
            return Ok(());
        }
        let coordinate = model.coordinate_names().get(fastest(v)).cloned().unwrap_or_default();
        Err(AdaptiveError::Diverged { coordinate, speed, time: to, step })
    }

    /// Enters the state y at `time` into everything that is kept, and shows it.
    ///
    /// # Errors
    /// [`AdaptiveError::Controller`], [`AdaptiveError::NotFinite`]: no torque or energy there; nothing is entered then.
    fn sample(
        &mut self,
        motion: &Motion<'_, '_>,
        time: f64,
        y: &[f64],
        is_last: bool,
    ) -> Result<ControlFlow<()>, AdaptiveError> {
        let (model, run) = (self.simulation.model, &mut *self.run);
        let mut tau = vec![0.0; model.nv()];
        let (mut q, mut v) = (Vec::new(), Vec::new());
        motion.split(y, &mut q, &mut v);
        motion.torque(time, &q, &v, &mut tau).map_err(|trouble| trouble.at(model, time))?;
        let (kinetic, potential) = energies(model, &mut self.workspace, &q, &v);
        let [work, dissipated] = [y[y.len() - 2], y[y.len() - 1]].map(|book| motion.energy * book);
        if !(kinetic + potential - work + dissipated).is_finite() {
            return Err(Trouble::NotFinite("the energy", fastest(&v)).at(model, time));
        }
        (run.q, run.v) = (q, v);
        run.ledger.enter(kinetic, potential, work, dissipated);
        for (peak, tau) in run.peak_torque.iter_mut().zip(&tau) {
            *peak = peak.max(tau.abs());
        }
        run.time = time;
        let step = self.samples;
        self.samples += 1;
        let moment = Moment {
            step,
            time,
            q: &run.q,
            v: &run.v,
            tau: &tau,
            ledger: &run.ledger,
            losses: None,
            contact_forces: &[],
            actuator_forces: &[],
            actuator_torques: &[],
        };
        let flow = (self.observer)(&moment);
        if self.simulation.keep_samples || step == 0 || is_last || flow.is_break() {
            run.trajectory.push(&moment);
        }
        if flow.is_break() {
            run.end = AdaptiveEnd::Interrupted;
        }
        Ok(flow)
    }

    /// Refuses to go on from a configuration in which M is singular.
    fn check_mass(&mut self, time: f64, q: &[f64]) -> Result<(), AdaptiveError> {
        check_rank(self.simulation.model, &mut self.workspace, q)
            .map_err(|source| AdaptiveError::SingularMass { time, source })
    }

    fn note_quaternions(&mut self, y: &[f64]) {
        for joint in self.simulation.model.joints().iter().filter(|joint| joint.nq > joint.nv) {
            let four = &y[joint.q_index + joint.nq - 4..joint.q_index + joint.nq];
            let off = (four.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs();
            self.run.quaternion_error = self.run.quaternion_error.max(off);
        }
    }
}

/// A controller asked once a period.
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

    fn ask(&mut self, q: &[f64], v: &[f64], tau: &mut [f64], model: &Model) -> Result<(), AdaptiveError> {
        let time = self.instant();
        self.controller
            .torque(time, q, v, tau)
            .map_err(|source| AdaptiveError::Controller { time, source })?;
        self.next += 1;
        Trouble::of(TORQUE, tau).map_or(Ok(()), |trouble| Err(trouble.at(model, time)))
    }
}

/// The next time to sample at: the end when there is none in between.
fn next_time(
    between: &mut impl Iterator<Item = f64>,
    count: &mut usize,
    before: f64,
    end: f64,
) -> Result<f64, AdaptiveError> {
    let Some(time) = between.next() else { return Ok(end) };
    let index = *count;
    *count += 1;
    if time > before && time < end { Ok(time) } else { Err(AdaptiveError::Times { index, time, before }) }
}
