//! Runs: sequences of steps with samples, events and an observer.

use std::ops::ControlFlow;
use std::sync::Arc;

use robot_dynamics_core::Model;

use super::memory::SimulationMemory;
use super::{Observer, RunOptions, Simulation};
use crate::motion::simulate::{EventDetector, StepInterpolation};
use crate::{Controller, Run, RunError, RunFailure, StepForces, Stepper, Trajectory};

impl Simulation {
    /// Runs for a duration \[s\] from (q, v) at time 0 with the held inputs: a [`reset`](Self::reset) of the
    /// state followed by a [`run`](Self::run).
    ///
    /// # Errors
    /// As [`reset`](Self::reset) and [`run`](Self::run). If (q, v) is an invalid start, the run in the
    /// failure has no samples.
    ///
    /// # Panics
    /// Panics if `v` has the wrong length.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
    /// use robot_dynamics::model::{Model, neutral};
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder};
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).build()?;
    /// let run = simulation.run_from(&neutral(&model), &[0.0; 6], 1.0, RunOptions::new().sample_period(0.1))?;
    /// // Free fall for one second.
    /// assert_eq!(run.trajectory.len(), 11);
    /// assert!((run.q[2] + 9.81 / 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn run_from(
        &mut self,
        q: &[f64],
        v: &[f64],
        duration: f64,
        options: RunOptions<'_, '_>,
    ) -> Result<Run, Box<RunFailure>> {
        let steps = self.steps_in(duration).map_err(|error| self.without_samples(error.into()))?;
        self.run_steps_from(q, v, steps, options)
    }

    /// [`run_from`](Self::run_from) with the number of steps instead of the duration.
    ///
    /// # Errors
    /// As [`run_from`](Self::run_from).
    ///
    /// # Panics
    /// Panics if `v` has the wrong length.
    #[track_caller]
    pub fn run_steps_from(
        &mut self,
        q: &[f64],
        v: &[f64],
        steps: usize,
        options: RunOptions<'_, '_>,
    ) -> Result<Run, Box<RunFailure>> {
        self.restart((q, v), 0.0, steps)?;
        self.activations.fill(0.0);
        self.limited.fill(0);
        self.run_steps(steps, options)
    }

    /// Runs for a duration \[s\] from the current state. Samples, events and peaks are those of this run
    /// only.
    ///
    /// The run takes the whole number of steps that is nearest to the duration; see
    /// [`steps_in`](Self::steps_in). [`Run::time`] is its end. A terminal event or the observer can end the run
    /// earlier.
    ///
    /// # Errors
    /// [`RunFailure`] for the reasons of [`step`](Self::step), or if the controller or the function of an
    /// event fails. It holds the run up to the failure. [`RunError::Input`] if the duration or the
    /// interval between samples is negative or not finite.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Event, RunOptions, SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).conservative().build()?;
    /// let mut events = [Event::new("vertical", |_, q: &[f64], _: &[f64]| q[0] - 1.5).terminal()];
    /// let run = simulation.run(1.0, RunOptions::new().events(&mut events))?;
    /// assert!(run.ended_by_event && (simulation.q()[0] - 1.5).abs() < 1e-9);
    /// assert!(run.energy_account.drift() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run(&mut self, duration: f64, options: RunOptions<'_, '_>) -> Result<Run, Box<RunFailure>> {
        let steps = self.steps_in(duration).map_err(|error| self.without_samples(error.into()))?;
        self.run_steps(steps, options)
    }

    /// [`run`](Self::run) with the number of steps instead of the duration.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder};
    /// let mut simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).dt(1e-3).build()?;
    /// let run = simulation.run_steps(25, RunOptions::new())?;
    /// assert_eq!((run.steps, run.time, run.trajectory.len()), (25, 0.025, 26));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run_steps(&mut self, steps: usize, options: RunOptions<'_, '_>) -> Result<Run, Box<RunFailure>> {
        let RunOptions { controller, events, observer, samples } = options;
        let sample_every = samples.steps(self.step).map_err(|error| self.without_samples(error.into()))?;
        let model = Arc::clone(&self.model);
        self.run.trajectory =
            Trajectory::new(&model, self.run_loop(&model, sample_every, self.base).samples_of(steps));
        self.run.events.clear();
        self.run.peak_torque.fill(0.0);
        (self.run.interrupted, self.run.ended_by_event) = (false, false);
        let done = EventDetector::start(events.unwrap_or(&mut []), self.run.time, &self.run.q, &self.run.v)
            .map_err(RunError::from)
            .and_then(|detector| {
                let seen_by = (controller, detector, observer);
                #[cfg(feature = "adaptive")]
                if self.is_adaptive() {
                    return self.follow(steps, sample_every, seen_by);
                }
                self.advance(&model, steps, sample_every, seen_by)
            });
        let empty = Trajectory::new(&model, 0);
        let trajectory = core::mem::replace(&mut self.run.trajectory, empty);
        let until = Run { trajectory, ..self.run.clone() };
        match done {
            Ok(()) => Ok(until),
            Err(error) => Err(Box::new(RunFailure { error, until })),
        }
    }

    /// The failure of a run that could not start, with the current state.
    fn without_samples(&self, error: RunError) -> Box<RunFailure> {
        let trajectory = Trajectory::new(&self.model, 0);
        Box::new(RunFailure { error, until: Run { trajectory, ..self.run.clone() } })
    }

    fn advance(
        &mut self,
        model: &Model,
        steps: usize,
        sample_every: usize,
        (mut controller, mut detector, mut observer): (
            Option<&mut dyn Controller>,
            EventDetector<'_, '_>,
            Option<Observer<'_>>,
        ),
    ) -> Result<(), RunError> {
        let mut between = StepInterpolation::new(model, self.stepper.order());
        let first = self.run.steps;
        for done in 0..=steps {
            let run_loop = self.run_loop(model, sample_every, self.base);
            let (step, time) = (self.run.steps, self.run.time);
            if let Some(controller) = &mut controller {
                let Self { run, inputs, .. } = self;
                controller
                    .torque(time, &run.q, &run.v, &mut inputs.torques)
                    .map_err(|source| RunError::Controller { step, time, source })?;
            }
            self.begin_step(&run_loop)?;
            let is_last = done == steps || self.run.ended_by_event;
            let kept_by_grid = done == 0 || (sample_every > 0 && done.is_multiple_of(sample_every));
            let (flow, is_kept) = self.record_instant(step - first, is_last || kept_by_grid, &mut observer);
            if is_last || flow.is_break() {
                self.run.trajectory.add_to_last_tau(self.stepper.actuator_torques());
                self.run.interrupted = !is_last;
                return Ok(());
            }
            self.check_mass(&run_loop)?;
            let Self { stepper, workspace, run, memory, .. } = self;
            let SimulationMemory { q, v, applied, before, .. } = &mut *memory;
            before.copy_from_slice(&run.v);
            let forces = StepForces::new(applied, self.dissipates);
            let looks = (workspace, &mut detector, &mut between);
            match run_loop.advance_once(run, stepper, looks, &forces, (q, v)) {
                Err(RunError::Step { source, .. }) if source.is_interruption() => {
                    // The step was discarded, so this state is the last one. The observer may have skipped it
                    // and is called again.
                    if !is_kept {
                        run.keep_sample(&memory.tau, stepper);
                    }
                    if let Some(observer) = &mut observer {
                        let _ = observer(&run.step_info(step - first, &memory.tau, stepper));
                    }
                    run.interrupted = true;
                    return Ok(());
                }
                taken => taken?,
            }
            self.finish_step(time, is_kept);
        }
        Ok(())
    }

    /// Calls the observer at the current instant, and keeps a sample if `must_keep` or if the observer ends
    /// the run. Returns the observer's answer, and whether a sample was kept.
    fn record_instant(
        &mut self,
        step: usize,
        must_keep: bool,
        observer: &mut Option<Observer<'_>>,
    ) -> (ControlFlow<()>, bool) {
        let info = self.run.step_info(step, &self.memory.tau, &self.stepper);
        let flow = observer.as_mut().map_or(ControlFlow::Continue(()), |observer| observer(&info));
        let is_kept = must_keep || flow.is_break();
        if is_kept {
            self.run.keep_sample(&self.memory.tau, &self.stepper);
        }
        (flow, is_kept)
    }

    /// Records the torques and the acceleration of the step that started at `time`. `is_kept` states whether
    /// its start is a sample.
    fn finish_step(&mut self, time: f64, is_kept: bool) {
        let Self { stepper, run, memory, .. } = self;
        let by_actuators = stepper.actuator_torques();
        if is_kept {
            run.trajectory.add_to_last_tau(by_actuators);
        }
        for (k, peak) in run.peak_torque.iter_mut().enumerate() {
            *peak = peak.max((memory.tau[k] + by_actuators.get(k).unwrap_or(&0.0)).abs());
        }
        let length = if run.ended_by_event { run.time - time } else { self.step };
        memory.record_acceleration(length);
        if run.ended_by_event {
            // Later steps are counted from the event.
            self.base = (run.steps, run.time);
        }
        self.end_step(length);
    }
}
