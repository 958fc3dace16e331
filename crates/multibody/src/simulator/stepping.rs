//! Steps and runs.

use core::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::error::StepFailure;
use super::method::SimulationStepper;
use super::{AppliedWrench, Effect, Method, MethodError};
use crate::model::length::check_length;
use crate::motion::simulate::{Between, Course, StepError, Watch};
use crate::{
    Actuation, CallbackError, ContactSet, Controller, ControllerError, Event, Model, Moment, Run, RunError,
    RunFailure, StepForces, StepWorkspace, Stepper, Trajectory, neutral,
};

/// A robot in time: its state, its inputs, and the steps.
///
/// It is made by a [`SimulationBuilder`](super::SimulationBuilder), which says what acts. The inputs (torques, controls, wrenches on frames) are held until
/// they are changed. Stepped one by one it gives the bits of one run. A step does not allocate.
///
/// ```
/// use multibody::{Model, pendulum, simulator::SimulationBuilder};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut simulation = SimulationBuilder::new(&model).build()?;
/// simulation.reset(&[0.3], &[0.0])?;
/// // A controller of one's own: it holds 0.3 rad.
/// for _ in 0..1000 {
///     let weight = model.gravity_forces(simulation.q())?[0];
///     let torque = weight + 50.0 * (0.3 - simulation.q()[0]) - 5.0 * simulation.v()[0];
///     simulation.set_torques(&[torque]);
///     simulation.step()?;
/// }
/// assert!((simulation.time() - 1.0).abs() < 1e-12 && (simulation.q()[0] - 0.3).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Simulation {
    pub(super) model: Arc<Model>,
    pub(super) step: f64,
    method: Method,
    reason: String,
    dissipates: bool,
    /// Of each coordinate, where effort limits act \[N·m or N\].
    effort: Option<Vec<f64>>,
    pub(super) stepper: SimulationStepper,
    /// As it was made.
    fresh: SimulationStepper,
    pub(super) actuation: Option<Actuation>,
    left_out: Vec<String>,
    acting: Vec<Effect>,
    contacts: Option<Arc<ContactSet>>,
    pub(super) inputs: Inputs,
    pub(super) run: Run,
    /// See [`Course::base`].
    pub(super) base: (usize, f64),
    /// Whether the state was checked for the next step.
    pub(super) is_checked: bool,
    pub(super) activations: Vec<f64>,
    /// Steps in which a torque was cut off at its limit, of each coordinate.
    pub(super) limited: Vec<usize>,
    workspace: StepWorkspace,
    memory: Memory,
}

/// What acts from outside, held until it is changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Inputs {
    pub(super) torques: Vec<f64>,
    pub(super) controls: Vec<f64>,
    pub(super) wrenches: Vec<AppliedWrench>,
}

#[derive(Clone, Debug)]
struct Memory {
    q: Vec<f64>,
    v: Vec<f64>,
    /// The mean acceleration of the last step.
    acceleration: Vec<f64>,
    /// The torques within their limits, and with the wrenches.
    tau: Vec<f64>,
    applied: Vec<f64>,
    middle: Vec<f64>,
    jacobian: Vec<f64>,
}

/// What a builder hands over.
pub(super) struct Parts {
    pub(super) model: Arc<Model>,
    pub(super) step: f64,
    pub(super) method: (Method, String),
    pub(super) dissipates: bool,
    pub(super) effort: Option<Vec<f64>>,
    pub(super) stepper: SimulationStepper,
    pub(super) actuation: Option<Actuation>,
    pub(super) left_out: Vec<String>,
    pub(super) acting: Vec<Effect>,
    pub(super) contacts: Option<ContactSet>,
}

/// How a run is made beside its length.
#[derive(Default)]
#[non_exhaustive]
pub struct RunOptions<'r, 'e> {
    /// Gives the torques at the start of each step; without it those of [`Simulation::set_torques`] are held.
    pub controller: Option<&'r mut dyn Controller>,
    /// What is watched for.
    pub events: Option<&'r mut [Event<'e>]>,
    /// Sees the state at the start of each step and at the end, and may break off.
    pub observer: Option<&'r mut dyn FnMut(&Moment<'_>) -> ControlFlow<()>>,
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

impl<'r, 'e> RunOptions<'r, 'e> {
    /// Every state is kept; nobody controls, watches or observes.
    pub fn new() -> Self {
        Self { sample_every: 1, ..Self::default() }
    }

    /// With torques from this controller.
    #[must_use]
    pub fn controller(self, controller: &'r mut dyn Controller) -> Self {
        Self { controller: Some(controller), ..self }
    }

    /// With these events.
    #[must_use]
    pub fn events(self, events: &'r mut [Event<'e>]) -> Self {
        Self { events: Some(events), ..self }
    }

    /// With this observer.
    #[must_use]
    pub fn observer(self, observer: &'r mut dyn FnMut(&Moment<'_>) -> ControlFlow<()>) -> Self {
        Self { observer: Some(observer), ..self }
    }

    /// With a sample every so many steps.
    #[must_use]
    pub fn sample_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }
}

impl fmt::Debug for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation")
            .field("robot", &self.model.name())
            .field("method", &self.method)
            .field("step", &self.step)
            .field("time", &self.run.time)
            .field("q", &self.run.q)
            .field("v", &self.run.v)
            .finish_non_exhaustive()
    }
}

impl Simulation {
    pub(super) fn of_parts(parts: Parts) -> Self {
        let Parts { model, step, method: (method, reason), dissipates, effort, stepper, .. } = parts;
        let Parts { actuation, left_out, acting, contacts, .. } = parts;
        let (nq, nv) = (model.nq(), model.nv());
        let zeros = || vec![0.0; nv];
        let mut workspace = StepWorkspace::new(&model);
        let controls = vec![0.0; actuation.as_ref().map_or(0, Actuation::control_count)];
        let course = Course { model: &model, step, dissipation: dissipates, sample_every: 0, base: (0, 0.0) };
        let mut opened = stepper.clone();
        let (run, _) = course.open(&mut opened, &mut workspace, (&neutral(&model), &zeros()), 0);
        Self {
            memory: Memory {
                q: vec![0.0; nq],
                v: zeros(),
                acceleration: zeros(),
                tau: zeros(),
                applied: zeros(),
                middle: controls.clone(),
                jacobian: vec![0.0; 6 * nv],
            },
            fresh: stepper.clone(),
            inputs: Inputs { torques: zeros(), controls: controls.clone(), wrenches: Vec::new() },
            activations: controls,
            limited: vec![0; nv],
            base: (0, 0.0),
            is_checked: false,
            model,
            step,
            method,
            reason,
            dissipates,
            effort,
            stepper,
            actuation,
            left_out,
            acting,
            contacts: contacts.map(Arc::new),
            run,
            workspace,
        }
    }

    /// The robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The step \[s\].
    pub fn step_size(&self) -> f64 {
        self.step
    }

    /// How the steps are taken.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Why they are taken so, in words.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// What the description states and this simulation leaves out, each with the reason.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// The effects that act: stated, not switched off, and known to the method.
    ///
    /// ```
    /// use multibody::{Model, PassiveForces, pendulum, simulator::{Effect, SimulationBuilder}};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_damping(0.3);
    /// let simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// assert_eq!(simulation.acting(), [Effect::Dissipation]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn acting(&self) -> &[Effect] {
        &self.acting
    }

    /// The contacts that there can be; `None` where there are none.
    pub fn contact_set(&self) -> Option<&ContactSet> {
        self.contacts.as_deref()
    }

    /// Whether damping and friction act.
    pub fn dissipates(&self) -> bool {
        self.dissipates
    }

    /// What takes the steps, as it was made, with controls at these values: for batches and linearised steps from states of their own.
    ///
    /// ```
    /// use multibody::{Model, StepForces, StepWorkspace, Stepper, pendulum, simulator::SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let simulation = SimulationBuilder::new(&model).build()?;
    /// let (mut q, mut v) = ([0.3], [0.0]);
    /// let forces = StepForces::new(&[0.0], simulation.dissipates());
    /// simulation.stepper().step(&model, &mut StepWorkspace::new(&model), &forces, 1e-3, &mut q, &mut v)?;
    /// assert!(v[0] > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stepper(&self) -> SimulationStepper {
        let mut stepper = self.fresh.clone();
        let controls = &self.inputs.controls;
        if let Some(actuation) = &self.actuation {
            let (mut start, mut middle) = (vec![0.0; controls.len()], vec![0.0; controls.len()]);
            actuation.activate(controls, 0.0, &mut start);
            actuation.activate(controls, 0.5 * self.step, &mut middle);
            stepper.set_controls(controls, &start, &middle);
        }
        stepper
    }

    /// Starts anew from (q, v) at time 0, with inputs at zero.
    ///
    /// # Errors
    /// [`RunError`]: q is invalid, v is not finite, the state is off the equalities, or M is singular there. The simulation is as before then.
    ///
    /// # Panics
    /// If v has the wrong length.
    #[track_caller]
    pub fn reset(&mut self, q: &[f64], v: &[f64]) -> Result<(), StepFailure> {
        self.restart(q, v, 0.0)?;
        self.inputs.torques.fill(0.0);
        self.inputs.controls.fill(0.0);
        self.inputs.wrenches.clear();
        self.activations.fill(0.0);
        self.limited.fill(0);
        Ok(())
    }

    /// Goes on from (q, v) at the same time, with the same inputs and activations. The energy account begins anew; forces of contacts, friction and stops of the
    /// step before are forgotten.
    ///
    /// # Errors
    /// As [`reset`](Self::reset).
    ///
    /// # Panics
    /// If v has the wrong length.
    #[track_caller]
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) -> Result<(), StepFailure> {
        self.restart(q, v, self.run.time)
    }

    #[track_caller]
    fn restart(&mut self, q: &[f64], v: &[f64], time: f64) -> Result<(), StepFailure> {
        let mut stepper = self.fresh.clone();
        let model = Arc::clone(&self.model);
        let course = self.course(&model, 0, (0, time));
        let (run, start) = course.open(&mut stepper, &mut self.workspace, (q, v), 1);
        start?;
        (self.run, self.stepper, self.base, self.is_checked) = (run, stepper, (0, time), true);
        self.memory.acceleration.fill(0.0);
        Ok(())
    }

    /// The torques of the next steps, nv entries \[N·m or N\].
    ///
    /// # Panics
    /// If their number is wrong.
    #[track_caller]
    pub fn set_torques(&mut self, torques: &[f64]) {
        check_length("the torques", torques.len(), self.inputs.torques.len());
        self.inputs.torques.copy_from_slice(torques);
    }

    /// The controls of the actuators in the next steps, in the order of [`control_names`](Self::control_names).
    ///
    /// # Panics
    /// If their number is wrong.
    #[track_caller]
    pub fn set_controls(&mut self, controls: &[f64]) {
        check_length("the controls", controls.len(), self.inputs.controls.len());
        self.inputs.controls.copy_from_slice(controls);
    }

    /// The wrenches on frames in the next steps, instead of those before.
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::{AppliedWrench, SimulationBuilder}};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).build()?;
    /// // The weight of the mass at its tip holds the rod level.
    /// let lift = AppliedWrench::force(model.frame_named("tip")?, [0.0, 0.0, 2.0 * 9.81]);
    /// simulation.set_wrenches(&[lift]);
    /// simulation.run_for(0.1)?;
    /// assert!(simulation.q()[0].abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a frame is another robot's.
    #[track_caller]
    pub fn set_wrenches(&mut self, wrenches: &[AppliedWrench]) {
        for wrench in wrenches {
            self.model.frame_of(wrench.frame);
        }
        self.inputs.wrenches.clear();
        self.inputs.wrenches.extend_from_slice(wrenches);
    }

    pub(super) fn course<'m>(&self, model: &'m Model, sample_every: usize, base: (usize, f64)) -> Course<'m> {
        Course { model, step: self.step, dissipation: self.dissipates, sample_every, base }
    }

    /// One step.
    ///
    /// # Errors
    /// [`RunError`]: an input is not finite, M is singular, an implicit step does not converge, or the motion grows without bound; with time and coordinate. The
    /// state is as before the step then.
    pub fn step(&mut self) -> Result<(), StepFailure> {
        let model = Arc::clone(&self.model);
        let course = self.course(&model, 0, self.base);
        self.begin_step(&course)?;
        self.check_mass(&course)?;
        let Self { stepper, workspace, run, memory, .. } = self;
        let forces = StepForces::new(&memory.applied, self.dissipates);
        let end = course.time(run.steps + 1);
        let state = (&mut memory.q[..], &mut memory.v[..]);
        let ledger = course.take(stepper, workspace, run, &forces, self.step, state)?;
        note_acceleration(memory, &run.v, self.step);
        Course::enter(run, stepper, (ledger, end), (&memory.q, &memory.v));
        self.end_step(self.step);
        Ok(())
    }

    /// Steps for a time \[s\], rounded to whole steps.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn run_for(&mut self, duration: f64) -> Result<(), StepFailure> {
        for _ in 0..self.steps_of(duration) {
            self.step()?;
        }
        Ok(())
    }

    /// How many steps come nearest to a time \[s\].
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).step(0.01).build()?;
    /// assert_eq!(simulation.steps_of(0.2499), 25);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a negative time has no steps
    pub fn steps_of(&self, duration: f64) -> usize {
        (duration / self.step).round() as usize
    }

    /// `steps` steps from where the simulation is, with samples, events and peaks of this run alone.
    ///
    /// # Errors
    /// [`RunFailure`], with all that the run did until then: as [`step`](Self::step), and where the controller or the function of an event fails.
    ///
    /// ```
    /// use multibody::{Event, Model, pendulum, simulator::{RunOptions, SimulationBuilder}};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).conservative().build()?;
    /// let mut events = [Event::new("vertical", |_, q: &[f64], _: &[f64]| q[0] - 1.5).terminal()];
    /// let run = simulation.run(1000, RunOptions::new().events(&mut events))?;
    /// assert!(run.ended_by_event && (simulation.q()[0] - 1.5).abs() < 1e-9);
    /// assert!(run.ledger.drift() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run(
        &mut self,
        steps: usize,
        options: RunOptions<'_, '_>,
    ) -> Result<Run, Box<RunFailure<MethodError>>> {
        let RunOptions { controller, events, observer, sample_every } = options;
        let model = Arc::clone(&self.model);
        self.run.trajectory = Trajectory::new(&model, samples_of(steps, sample_every));
        self.run.events.clear();
        self.run.peak_torque.fill(0.0);
        (self.run.interrupted, self.run.ended_by_event) = (false, false);
        let done = Watch::start(events.unwrap_or(&mut []), self.run.time, &self.run.q, &self.run.v)
            .map_err(RunError::from)
            .and_then(|watch| self.advance(&model, steps, sample_every, (controller, watch, observer)));
        let empty = Trajectory::new(&model, 0);
        let trajectory = core::mem::replace(&mut self.run.trajectory, empty);
        let until = Run { trajectory, ..self.run.clone() };
        match done {
            Ok(()) => Ok(until),
            Err(error) => Err(Box::new(RunFailure { error, until })),
        }
    }

    fn advance(
        &mut self,
        model: &Model,
        steps: usize,
        sample_every: usize,
        (mut controller, mut watch, mut observer): (
            Option<&mut dyn Controller>,
            Watch<'_, '_>,
            Option<&mut dyn FnMut(&Moment<'_>) -> ControlFlow<()>>,
        ),
    ) -> Result<(), StepFailure> {
        let mut between = Between::new(model, self.stepper.order());
        let first = self.run.steps;
        for done in 0..=steps {
            let course = self.course(model, sample_every, self.base);
            let (step, time) = (self.run.steps, self.run.time);
            if let Some(controller) = &mut controller {
                let Self { run, inputs, .. } = self;
                controller
                    .torque(time, &run.q, &run.v, &mut inputs.torques)
                    .map_err(|source| RunError::Controller { step, time, source })?;
            }
            self.begin_step(&course)?;
            let is_last = done == steps || self.run.ended_by_event;
            let (flow, is_kept) = {
                let moment = Moment {
                    step: step - first,
                    time,
                    q: &self.run.q,
                    v: &self.run.v,
                    tau: &self.memory.tau,
                    ledger: &self.run.ledger,
                    losses: self.run.losses,
                    contact_forces: self.stepper.contact_forces(),
                    actuator_forces: self.stepper.actuator_forces(),
                    actuator_torques: self.stepper.actuator_torques(),
                };
                let flow = observer.as_mut().map_or(ControlFlow::Continue(()), |observer| observer(&moment));
                let is_kept = is_last || flow.is_break() || done == 0;
                let is_kept = is_kept || (sample_every > 0 && done.is_multiple_of(sample_every));
                if is_kept {
                    self.run.trajectory.push(&moment);
                }
                (flow, is_kept)
            };
            if is_last || flow.is_break() {
                self.run.trajectory.add_to_last_tau(self.stepper.actuator_torques());
                self.run.interrupted = !is_last;
                return Ok(());
            }
            self.check_mass(&course)?;
            let Self { stepper, workspace, run, memory, .. } = self;
            let Memory { q, v, applied, .. } = &mut *memory;
            let (before, velocity) = (run.time, run.v.clone());
            let forces = StepForces::new(applied, self.dissipates);
            let looks = (workspace, &mut watch, &mut between);
            match course.advance_once(run, stepper, looks, &forces, (q, v)) {
                Err(RunError::Step { source, .. }) if source.is_interruption() => {
                    // As the step was taken back, this sample is the last.
                    if !is_kept {
                        run.trajectory.push(&Moment {
                            step: step - first,
                            time,
                            q: &run.q,
                            v: &run.v,
                            tau: &memory.tau,
                            ledger: &run.ledger,
                            losses: run.losses,
                            contact_forces: stepper.contact_forces(),
                            actuator_forces: stepper.actuator_forces(),
                            actuator_torques: stepper.actuator_torques(),
                        });
                    }
                    run.interrupted = true;
                    return Ok(());
                }
                taken => taken?,
            }
            let by_actuators = stepper.actuator_torques();
            if is_kept {
                run.trajectory.add_to_last_tau(by_actuators);
            }
            for (k, peak) in run.peak_torque.iter_mut().enumerate() {
                *peak = peak.max((memory.tau[k] + by_actuators.get(k).unwrap_or(&0.0)).abs());
            }
            let length = if run.ended_by_event { run.time - before } else { self.step };
            note_acceleration(memory, &velocity, length);
            if run.ended_by_event {
                // What follows is counted from the event.
                self.base = (run.steps, run.time);
            }
            self.end_step(length);
        }
        Ok(())
    }

    /// Checks the inputs, cuts torques off at their limits, and makes generalised forces of wrenches.
    fn begin_step(&mut self, course: &Course<'_>) -> Result<(), StepFailure> {
        let Self { model, inputs, run, memory, effort, workspace, .. } = self;
        if let Some(index) = inputs.torques.iter().position(|tau| !tau.is_finite()) {
            return Err(course.blow_up("the controller's torque", index, run.steps));
        }
        memory.tau.copy_from_slice(&inputs.torques);
        if let Some(effort) = effort {
            for (tau, limit) in memory.tau.iter_mut().zip(effort.iter()) {
                *tau = tau.clamp(-limit.max(0.0), limit.max(0.0));
            }
        }
        memory.applied.copy_from_slice(&memory.tau);
        for wrench in &inputs.wrenches {
            if !wrench.is_finite() {
                let frame = &model.frame_of(wrench.frame).name;
                return Err(bad_input(run, format!("the wrench on frame `{frame}` is not finite")));
            }
            let Memory { jacobian, applied, .. } = memory;
            wrench.add_to(model, workspace.dynamics(), &run.q, jacobian, applied);
        }
        if let Some(actuation) = &self.actuation {
            if let Some(index) = inputs.controls.iter().position(|control| !control.is_finite()) {
                let name = actuation.control_names().nth(index).unwrap_or_default();
                let control = inputs.controls[index];
                return Err(bad_input(run, format!("the control of actuator `{name}` is {control}")));
            }
            let half = 0.5 * self.step;
            actuation.activate(&inputs.controls, 0.0, &mut self.activations);
            memory.middle.copy_from_slice(&self.activations);
            actuation.activate(&inputs.controls, half, &mut memory.middle);
            self.stepper.set_controls(&inputs.controls, &self.activations, &memory.middle);
        }
        Ok(())
    }

    /// The start of a run was looked at when it was set.
    fn check_mass(&mut self, course: &Course<'_>) -> Result<(), StepFailure> {
        let steps = self.run.steps;
        if !core::mem::replace(&mut self.is_checked, false) {
            let checked = course.check_mass(&mut self.stepper, &mut self.workspace, &self.run.q, steps);
            checked.map_err(|error| course.named(&self.stepper, &self.run, error))?;
        }
        Ok(())
    }

    /// Counts the torques that were cut off, and lets the activations follow their controls for the step's length \[s\].
    fn end_step(&mut self, length: f64) {
        let Self { limited, inputs, memory, activations, .. } = self;
        for (k, count) in limited.iter_mut().enumerate() {
            *count += usize::from(memory.tau[k] != inputs.torques[k]);
        }
        if let Some(actuation) = &self.actuation {
            actuation.activate(&inputs.controls, length, activations);
        }
    }

    /// The mean acceleration of the last step, (v₁ − v₀)/h.
    pub(super) fn mean_acceleration(&self) -> &[f64] {
        &self.memory.acceleration
    }

    /// The torques of the last step within their limits.
    pub(super) fn limited_torques(&self) -> &[f64] {
        &self.memory.tau
    }
}

fn bad_input(run: &Run, message: String) -> StepFailure {
    let source = ControllerError::Callback(CallbackError::new(message));
    RunError::Controller { step: run.steps, time: run.time, source }
}

fn note_acceleration(memory: &mut Memory, before: &[f64], h: f64) {
    let Memory { acceleration, v, .. } = memory;
    for (k, acceleration) in acceleration.iter_mut().enumerate() {
        *acceleration = (v[k] - before[k]) / h;
    }
}

/// Samples that a run of so many steps keeps; memory for a million is taken at once, for more as it comes.
fn samples_of(steps: usize, sample_every: usize) -> usize {
    (steps.checked_div(sample_every).unwrap_or(0) + 2).min(1_000_000)
}
