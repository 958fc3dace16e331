//! The simulation and its steps.

use core::fmt;
use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

use super::memory::{ControllerSteps, SimulationMemory};
use super::method::SimulationStepper;
use super::{AppliedWrench, Effect, Method};
use crate::motion::simulate::RunLoop;
use crate::{Actuation, ContactSet, Run, RunError, RunFailure, StepForces, StepWorkspace};

/// The simulation of one robot: its state, its inputs, and its steps.
///
/// A [`SimulationBuilder`](super::SimulationBuilder) creates it and selects the effects. The inputs (torques,
/// controls, wrenches on frames) are held until they are changed. Single steps give the same bits as one run;
/// adaptive steps agree to their tolerance. A step does not allocate.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::SimulationBuilder;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut simulation = SimulationBuilder::new(&model).build()?;
/// simulation.reset(&[0.3], &[0.0])?;
/// // A custom controller that holds 0.3 rad.
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
    /// Effort limit of each coordinate \[N·m or N\]; `None` if effort limits do not act.
    pub(super) effort: Option<Vec<f64>>,
    pub(super) stepper: SimulationStepper,
    /// The stepper before its first step.
    fresh: SimulationStepper,
    pub(super) actuation: Option<Actuation>,
    left_out: Vec<String>,
    acting: Vec<Effect>,
    contacts: Option<Arc<ContactSet>>,
    pub(super) inputs: Inputs,
    pub(super) run: Run,
    /// See [`RunLoop::base`].
    pub(super) base: (usize, f64),
    /// Whether the current state was checked for the next step.
    pub(super) is_checked: bool,
    pub(super) activations: Vec<f64>,
    /// The number of steps in which the torque of each coordinate was clipped.
    pub(super) limited: Vec<usize>,
    pub(super) workspace: StepWorkspace,
    pub(super) memory: SimulationMemory,
}

/// External inputs, held until they are changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Inputs {
    pub(super) torques: Vec<f64>,
    pub(super) controls: Vec<f64>,
    pub(super) wrenches: Vec<AppliedWrench>,
}

/// The parts from which a builder creates a simulation.
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
        let activations = vec![0.0; actuation.as_ref().map_or(0, Actuation::activation_count)];
        let run_loop =
            RunLoop { model: &model, step, dissipation: dissipates, sample_every: 0, base: (0, 0.0) };
        let mut opened = stepper.clone();
        let (run, _) =
            run_loop.open(&mut opened, &mut workspace, (&model.initial_configuration(), &zeros()), 0);
        Self {
            memory: SimulationMemory {
                q: vec![0.0; nq],
                v: zeros(),
                acceleration: zeros(),
                before: zeros(),
                tau: zeros(),
                applied: zeros(),
                middle: activations.clone(),
                states: actuation.as_ref().and_then(|actuation| ControllerSteps::new(actuation, nq, nv)),
                jacobian: vec![0.0; 6 * nv],
            },
            fresh: stepper.clone(),
            inputs: Inputs { torques: zeros(), controls, wrenches: Vec::new() },
            activations,
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
    #[doc(alias = "step_size")]
    pub fn dt(&self) -> f64 {
        self.step
    }

    /// The integration method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The reason for the choice of the method.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// The features that the description states and this simulation leaves out, each with the reason.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// The effects that act: stated in the description, not switched off, and supported by the method.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Effect, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_damping(0.3);
    /// let simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// assert_eq!(simulation.acting(), [Effect::Dissipation]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn acting(&self) -> &[Effect] {
        &self.acting
    }

    /// The possible contacts; `None` if nothing can touch.
    pub fn contact_set(&self) -> Option<&ContactSet> {
        self.contacts.as_deref()
    }

    /// Whether damping and friction act.
    pub fn dissipates(&self) -> bool {
        self.dissipates
    }

    /// A copy of the stepper before its first step, with controls at these values, for batches and linearized
    /// steps.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{SimulationBuilder, StepForces, StepWorkspace, Stepper};
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
            let mut start = vec![0.0; actuation.activation_count()];
            let mut middle = start.clone();
            actuation.activate(controls, 0.0, &mut start);
            actuation.activate(controls, 0.5 * self.step, &mut middle);
            stepper.set_controls(controls, &start, &middle);
        }
        stepper
    }

    /// Converts the simulation to its stepper without a copy. The stepper keeps its memory, so that its steps
    /// do not allocate.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{SimulationBuilder, Stepper};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(SimulationBuilder::new(&model).build()?.into_stepper().order(), 4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn into_stepper(self) -> SimulationStepper {
        self.stepper
    }

    /// Restarts from (q, v) at time 0 with all inputs at zero.
    ///
    /// # Errors
    /// [`RunError`](crate::RunError) if q is invalid, v is not finite, the state violates the equalities, or
    /// M is singular. The simulation is then unchanged.
    ///
    /// # Panics
    /// Panics if `v` has the wrong length.
    #[track_caller]
    pub fn reset(&mut self, q: &[f64], v: &[f64]) -> Result<(), RunError> {
        self.restart((q, v), 0.0, 1).map_err(|failure| failure.error)?;
        self.inputs.torques.fill(0.0);
        self.inputs.controls.fill(0.0);
        self.inputs.wrenches.clear();
        self.activations.fill(0.0);
        self.limited.fill(0);
        Ok(())
    }

    /// Continues from (q, v) at the current time with the current inputs, activations and rest positions. The
    /// energy account restarts. The forces of contacts, friction and stops of earlier steps are discarded.
    ///
    /// # Errors
    /// As [`reset`](Self::reset).
    ///
    /// # Panics
    /// Panics if `v` has the wrong length.
    #[track_caller]
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) -> Result<(), RunError> {
        let before = self.with_yielded_springs();
        self.restart((q, v), self.run.time, 1).map_err(|failure| failure.error)?;
        self.stepper.copy_rest_positions(before.as_ref());
        Ok(())
    }

    /// Restarts for a number of steps; with none, M may be singular. If (q, v) is an invalid start, the
    /// simulation is unchanged, and the run in the failure ends in the neutral configuration at rest.
    #[track_caller]
    pub(super) fn restart(
        &mut self,
        (q, v): (&[f64], &[f64]),
        time: f64,
        steps: usize,
    ) -> Result<(), Box<RunFailure>> {
        let mut stepper = self.fresh.clone();
        let model = Arc::clone(&self.model);
        let run_loop = self.run_loop(&model, 0, (0, time));
        let (run, start) = run_loop.open(&mut stepper, &mut self.workspace, (q, v), steps);
        if let Err(error) = start {
            return Err(Box::new(RunFailure { error, until: run }));
        }
        // In place, to keep the memory that steps have allocated.
        self.stepper.clone_from(&stepper);
        (self.run, self.base, self.is_checked) = (run, (0, time), steps > 0);
        self.memory.acceleration.fill(0.0);
        Ok(())
    }

    pub(super) fn run_loop<'m>(
        &self,
        model: &'m Model,
        sample_every: usize,
        base: (usize, f64),
    ) -> RunLoop<'m> {
        RunLoop { model, step: self.step, dissipation: self.dissipates, sample_every, base }
    }

    /// Takes one step.
    ///
    /// # Errors
    /// [`RunError`](crate::RunError), with the time and the coordinate. Causes are an input that is not
    /// finite, a singular M, an implicit step that does not converge, and divergence. The simulation is then
    /// unchanged.
    pub fn step(&mut self) -> Result<(), RunError> {
        #[cfg(feature = "adaptive")]
        if self.is_adaptive() {
            return self.step_adaptively();
        }
        let model = Arc::clone(&self.model);
        let run_loop = self.run_loop(&model, 0, self.base);
        self.begin_step(&run_loop)?;
        self.check_mass(&run_loop)?;
        let Self { stepper, workspace, run, memory, .. } = self;
        memory.before.copy_from_slice(&run.v);
        let forces = StepForces::new(&memory.applied, self.dissipates);
        let end = run_loop.time(run.steps + 1);
        let state = (&mut memory.q[..], &mut memory.v[..]);
        let energy_account = run_loop.take_step(stepper, workspace, run, &forces, self.step, state)?;
        memory.record_acceleration(self.step);
        RunLoop::enter(run, stepper, (energy_account, end), (&memory.q, &memory.v));
        self.end_step(self.step);
        Ok(())
    }

    /// Takes steps for a duration \[s\] without samples, events or an observer: the whole number of steps
    /// that is nearest to it.
    ///
    /// # Errors
    /// As [`step`](Self::step) and [`steps_in`](Self::steps_in).
    pub fn run_for(&mut self, duration: f64) -> Result<(), RunError> {
        for _ in 0..self.steps_in(duration)? {
            self.step()?;
        }
        Ok(())
    }

    /// The whole number of steps that is nearest to a duration \[s\]; see
    /// [`steps_in`](crate::steps_in).
    ///
    /// # Errors
    /// [`InvalidInput`] if the duration is negative or not finite.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).dt(0.01).build()?;
    /// assert_eq!(simulation.steps_in(0.2499)?, 25);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "steps_of")]
    pub fn steps_in(&self, duration: f64) -> Result<usize, InvalidInput> {
        crate::steps_in(duration, self.step)
    }

    /// The mean acceleration of the last step, (v₁ − v₀)/h.
    pub(super) fn mean_acceleration(&self) -> &[f64] {
        &self.memory.acceleration
    }

    /// The torques of the last step after effort limits.
    pub(super) fn limited_torques(&self) -> &[f64] {
        &self.memory.tau
    }
}
