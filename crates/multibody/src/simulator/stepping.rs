//! Steps and runs.

use core::fmt;
use std::sync::Arc;

use super::error::StepFailure;
use super::method::SimulationStepper;
use super::step_inputs::note_acceleration;
use super::{AppliedWrench, Effect, Method, MethodError};
use crate::motion::simulate::Course;
use crate::{Actuation, ContactSet, Model, Run, RunFailure, StepForces, StepWorkspace};

/// A robot in time: its state, its inputs, and the steps.
///
/// It is made by a [`SimulationBuilder`](super::SimulationBuilder), which says what acts. The inputs (torques, controls, wrenches on frames) are held until
/// they are changed. Stepped one by one it gives the bits of one run, and a step does not allocate; adaptive steps give the same to their tolerance.
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
    pub(super) dissipates: bool,
    /// One entry for each coordinate, where effort limits act \[N·m or N\].
    pub(super) effort: Option<Vec<f64>>,
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
    pub(super) workspace: StepWorkspace,
    pub(super) memory: Memory,
}

/// Inputs from outside, held until they are changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Inputs {
    pub(super) torques: Vec<f64>,
    pub(super) controls: Vec<f64>,
    pub(super) wrenches: Vec<AppliedWrench>,
}

#[derive(Clone, Debug)]
pub(super) struct Memory {
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// The mean acceleration of the last step.
    pub(super) acceleration: Vec<f64>,
    /// The velocity where a step starts.
    pub(super) before: Vec<f64>,
    /// The torques within their limits, and with the wrenches.
    pub(super) tau: Vec<f64>,
    pub(super) applied: Vec<f64>,
    pub(super) middle: Vec<f64>,
    pub(super) jacobian: Vec<f64>,
}

/// The parts that a builder makes a simulation of.
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
        let (run, _) =
            course.open(&mut opened, &mut workspace, (&model.initial_configuration(), &zeros()), 0);
        Self {
            memory: Memory {
                q: vec![0.0; nq],
                v: zeros(),
                acceleration: zeros(),
                before: zeros(),
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

    /// The features that the description states and this simulation leaves out, each with the reason.
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

    /// The stepper, as it was made, with controls at these values: for batches and linearised steps from states of their own.
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

    /// The stepper, as the simulation leaves it, without a copy: it keeps its memory, so that its steps do not allocate.
    ///
    /// ```
    /// use multibody::{Model, Stepper, pendulum, simulator::SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(SimulationBuilder::new(&model).build()?.into_stepper().order(), 4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn into_stepper(self) -> SimulationStepper {
        self.stepper
    }

    /// Starts anew from (q, v) at time 0, with inputs at zero.
    ///
    /// # Errors
    /// [`RunError`](crate::RunError): q is invalid, v is not finite, the state is off the equalities, or M is singular there. The simulation is as before then.
    ///
    /// # Panics
    /// If v has the wrong length.
    #[track_caller]
    pub fn reset(&mut self, q: &[f64], v: &[f64]) -> Result<(), StepFailure> {
        self.restart((q, v), 0.0, 1).map_err(|failure| failure.error)?;
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
        self.restart((q, v), self.run.time, 1).map_err(|failure| failure.error)
    }

    /// For so many steps: none need no inverse of M. Where there is no start from (q, v), the failure has neutral at rest as the end of its run, and all is as before.
    #[track_caller]
    pub(super) fn restart(
        &mut self,
        (q, v): (&[f64], &[f64]),
        time: f64,
        steps: usize,
    ) -> Result<(), Box<RunFailure<MethodError>>> {
        let mut stepper = self.fresh.clone();
        let model = Arc::clone(&self.model);
        let course = self.course(&model, 0, (0, time));
        let (run, start) = course.open(&mut stepper, &mut self.workspace, (q, v), steps);
        if let Err(error) = start {
            return Err(Box::new(RunFailure { error, until: run }));
        }
        // In place, so that it keeps the memory that steps have grown.
        self.stepper.clone_from(&stepper);
        (self.run, self.base, self.is_checked) = (run, (0, time), steps > 0);
        self.memory.acceleration.fill(0.0);
        Ok(())
    }

    pub(super) fn course<'m>(&self, model: &'m Model, sample_every: usize, base: (usize, f64)) -> Course<'m> {
        Course { model, step: self.step, dissipation: self.dissipates, sample_every, base }
    }

    /// One step.
    ///
    /// # Errors
    /// [`RunError`](crate::RunError): an input is not finite, M is singular, an implicit step does not converge, or the motion grows without bound; with time and coordinate. The
    /// state is as before the step then.
    pub fn step(&mut self) -> Result<(), StepFailure> {
        #[cfg(feature = "adaptive")]
        if self.is_adaptive() {
            return self.step_adaptively();
        }
        let model = Arc::clone(&self.model);
        let course = self.course(&model, 0, self.base);
        self.begin_step(&course)?;
        self.check_mass(&course)?;
        let Self { stepper, workspace, run, memory, .. } = self;
        memory.before.copy_from_slice(&run.v);
        let forces = StepForces::new(&memory.applied, self.dissipates);
        let end = course.time(run.steps + 1);
        let state = (&mut memory.q[..], &mut memory.v[..]);
        let ledger = course.take(stepper, workspace, run, &forces, self.step, state)?;
        note_acceleration(memory, self.step);
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

    /// The mean acceleration of the last step, (v₁ − v₀)/h.
    pub(super) fn mean_acceleration(&self) -> &[f64] {
        &self.memory.acceleration
    }

    /// The torques of the last step within their limits.
    pub(super) fn limited_torques(&self) -> &[f64] {
        &self.memory.tau
    }
}
