//! A run whose forces follow the state within each step: actuators, tendons, carried weight.

use std::cell::RefCell;
use std::error::Error;
use std::ops::ControlFlow;

use dynamics::{DynamicsError, EnergyLedger, Integrator, IntegratorError, Method, Stage};

use super::ledger::travel;
use super::{Course, Moment, Outcome, Run, RunFailure, StepError, StepFault, Stepper};
use crate::motion::integrate::explicit::{Motion, StageMemory, advance, explicit_names};
use crate::motion::integrate::{accelerate, check_step};
use crate::{
    Actuation, ActuationWorkspace, Event, Model, StepForces, StepWorkspace, Workspace, dissipation, integrate,
};

/// A run of a robot with its actuators: the controls are held over each step, the forces that follow from them and from
/// tendons and carried weight are taken at every stage of the method.
///
/// ```
/// use dynamics::Integrator;
/// use multibody::{Actuation, ActuatedSimulation, ActuatorDescription, Model, Transmission, pendulum};
/// use std::ops::ControlFlow;
/// let mut robot = pendulum(2.0, 0.5);
/// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(500.0, 50.0);
/// robot.actuators.push(servo);
/// let model = Model::new(robot)?;
/// let actuation = Actuation::new(&model)?;
/// let simulation = ActuatedSimulation::new(&model, &actuation, Integrator::RungeKutta4, 1e-3);
/// let mut controls = |_t: f64, _q: &[f64], _v: &[f64], u: &mut [f64]| u[0] = 1.0; // to 1 rad
/// let run = simulation.run(&[0.0], &[0.0], 3000, &mut controls, |_| ControlFlow::Continue(()))?;
/// // It rests where the servo carries the weight: 500 (1 − q) = g(q).
/// let weight = model.gravity_forces(&run.q)?[0];
/// assert!((500.0 * (1.0 - run.q[0]) - weight).abs() < 1e-6);
/// assert!(run.ledger.max_imbalance() < 1e-4 * run.ledger.scale()); // the books close
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ActuatedSimulation<'a> {
    /// The robot.
    pub model: &'a Model,
    /// What drives it.
    pub actuation: &'a Actuation,
    /// A row with explicit stages.
    pub integrator: Integrator,
    /// The step, over which the controls are held \[s\].
    pub step: f64,
    /// Whether the joints' damping and friction act; tendons' always do.
    pub dissipation: bool,
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

impl<'a> ActuatedSimulation<'a> {
    /// With steps of that length \[s\]; damping and friction act, and every state is kept.
    pub const fn new(model: &'a Model, actuation: &'a Actuation, integrator: Integrator, step: f64) -> Self {
        Self { model, actuation, integrator, step, dissipation: true, sample_every: 1 }
    }

    /// Whether the joints' damping and friction act.
    pub fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub fn with_samples_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }

    /// Runs `steps` steps from (q0, v0). `controls` writes u, one number for each actuator, for the state at the start of a
    /// step; activations start at 0 and follow their control at every stage. Torques in samples and moments are those at a
    /// step's start; what springs of tendons and carried weight store counts as potential energy.
    ///
    /// # Errors
    /// As [`Simulation::run`](crate::Simulation::run); [`ActuatedStepError::NotExplicit`] for a variational row.
    ///
    /// # Panics
    /// If v0 has the wrong length.
    #[track_caller]
    pub fn run<R: Outcome<()>>(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controls: impl FnMut(f64, &[f64], &[f64], &mut [f64]) -> R,
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Box<RunFailure<ActuatedStepError>>> {
        self.run_with_events(q0, v0, steps, controls, &mut [], observer)
    }

    /// As [`run`](Self::run), with events watched for all along: [`Run::events`].
    ///
    /// # Errors
    /// As [`run`](Self::run).
    ///
    /// # Panics
    /// If v0 has the wrong length.
    #[track_caller]
    pub fn run_with_events<R: Outcome<()>>(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        mut controls: impl FnMut(f64, &[f64], &[f64], &mut [f64]) -> R,
        events: &mut [Event<'_>],
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Box<RunFailure<ActuatedStepError>>> {
        let Self { model, actuation, integrator, step, dissipation, sample_every } = *self;
        let count = actuation.control_count();
        let held = RefCell::new(Held { at: 0.0, controls: vec![0.0; count], activations: vec![0.0; count] });
        let mut stepper = Actuated {
            actuation,
            integrator,
            memory: actuation.workspace(),
            held: &held,
            activations: vec![0.0; count],
        };
        let mut memory = actuation.workspace();
        let mut controller =
            |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| -> Result<(), Box<dyn Error + Send + Sync>> {
                let held = &mut *held.borrow_mut();
                let elapsed = t - core::mem::replace(&mut held.at, t);
                if elapsed > 0.0 {
                    actuation.activate(&held.controls, elapsed, &mut held.activations);
                }
                controls(t, q, v, &mut held.controls).outcome()?;
                if let Some(k) = held.controls.iter().position(|u| !u.is_finite()) {
                    let name = actuation.control_names().nth(k).unwrap_or_default();
                    return Err(format!("the control of actuator `{name}` is {}", held.controls[k]).into());
                }
                actuation.activate(&held.controls, 0.0, &mut held.activations);
                actuation.forces(model, &mut memory, &held.activations, q, v, tau);
                Ok(())
            };
        let course = Course { model, step, dissipation, sample_every };
        course.run(&mut stepper, (q0, v0), steps, &mut controller, events, observer)
    }
}

/// Why a step with actuators could not be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ActuatedStepError {
    /// The row has no explicit stages.
    #[error(
        "`{integrator}` holds its forces over a step, actuators follow the state; take one of {}",
        explicit_names()
    )]
    NotExplicit {
        /// Its name.
        integrator: &'static str,
    },
    /// As for any step.
    #[error(transparent)]
    Step(#[from] IntegratorError),
}

impl From<DynamicsError> for ActuatedStepError {
    fn from(error: DynamicsError) -> Self {
        Self::Step(error.into())
    }
}

impl StepError for ActuatedStepError {
    fn fault(self, model: &Model) -> StepFault<Self> {
        match self {
            Self::Step(error) => match error.fault(model) {
                StepFault::NotFinite { quantity, index } => StepFault::NotFinite { quantity, index },
                StepFault::SingularMass(source) => StepFault::SingularMass(source),
                StepFault::Other(error) => StepFault::Other(Self::Step(error)),
            },
            other => StepFault::Other(other),
        }
    }
}

/// What is held over a step.
struct Held {
    /// Time of the last control \[s\].
    at: f64,
    controls: Vec<f64>,
    activations: Vec<f64>,
}

impl Held {
    /// The activations so long after the step's start, in `memory`.
    fn after<'m>(&self, actuation: &Actuation, time: f64, memory: &'m mut [f64]) -> &'m [f64] {
        memory.copy_from_slice(&self.activations);
        if time > 0.0 {
            actuation.activate(&self.controls, time, memory);
        }
        memory
    }
}

/// Takes the steps of a run with actuators.
#[derive(Clone)]
struct Actuated<'a> {
    actuation: &'a Actuation,
    integrator: Integrator,
    memory: ActuationWorkspace,
    held: &'a RefCell<Held>,
    /// Memory for the activations within a step.
    activations: Vec<f64>,
}

impl Stepper for Actuated<'_> {
    type Error = ActuatedStepError;

    fn order(&self) -> u32 {
        self.integrator.order()
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), ActuatedStepError> {
        check_step(h)?;
        let Method::Explicit(stages) = self.integrator.method() else {
            return Err(ActuatedStepError::NotExplicit { integrator: self.integrator.name() });
        };
        let StepWorkspace { dynamics, force, held: driven, stages: memory, .. } = workspace;
        let mut memory = StageMemory::new(model, stages.len(), memory);
        let mut motion = Driven {
            model,
            workspace: dynamics,
            actuation: (self.actuation, &mut self.memory),
            held: &self.held.borrow(),
            activations: &mut self.activations,
            times: stages
                .iter()
                .enumerate()
                .filter(|(at, _)| Stage::needs_acceleration(stages, *at))
                .map(|(_, stage)| h * stage.v_row.iter().sum::<f64>()),
            driven,
            dissipation: forces.dissipation,
            force,
        };
        Ok(advance(model, stages, &mut motion, h, &mut memory, (q, v))?)
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.actuation.stored_energy(&mut self.memory, q)
    }

    /// Work and losses by Simpson's rule over the step's ends and middle, of order 4; bounds that are met inside a step
    /// cost it that order there.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        ledger: &mut EnergyLedger,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) {
        let (kinetic, potential) = travel(model, workspace, from, to, h);
        let stored = self.stored_energy(to.0);
        let StepWorkspace { displacement, q: middle_q, v: middle_v, force, .. } = workspace;
        // The cubic through the ends: half the way, and an eighth of h times the velocities' difference.
        for k in 0..displacement.len() {
            displacement[k] = 0.5 * displacement[k] + h / 8.0 * (from.1[k] - to.1[k]);
        }
        integrate(model, from.0, displacement, middle_q);
        let held = self.held.borrow();
        let mut powers = |time: f64, q: &[f64], v: &[f64]| {
            let u = held.after(self.actuation, time, &mut self.activations);
            let input = self.actuation.input_power(model, &mut self.memory, u, (q, v), force);
            let mut lost = self.actuation.dissipated_power(q, v);
            if forces.dissipation {
                dissipation(model, v, force);
                lost += force.iter().zip(v).map(|(b, v)| b * v).sum::<f64>();
            }
            (input, lost)
        };
        let (start, middle, end) =
            (powers(0.0, from.0, from.1), powers(0.5 * h, middle_q, middle_v), powers(h, to.0, to.1));
        let mean = |a: f64, b: f64, c: f64| h / 6.0 * (a + 4.0 * b + c);
        let work = ledger.work() + mean(start.0, middle.0, end.0);
        let dissipated = ledger.dissipated() + mean(start.1, middle.1, end.1);
        ledger.enter(kinetic, potential + stored, work, dissipated);
    }
}

/// A tree under forces that follow its state.
struct Driven<'a, T> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    actuation: (&'a Actuation, &'a mut ActuationWorkspace),
    held: &'a Held,
    /// Memory for those of a stage.
    activations: &'a mut [f64],
    /// When each stage that asks for an acceleration is, after the step's start \[s\].
    times: T,
    /// Memory for what they give, and for that less b(v).
    driven: &'a mut [f64],
    force: &'a mut [f64],
    /// Whether the joints' damping and friction act.
    dissipation: bool,
}

impl<T: Iterator<Item = f64>> Motion<f64> for Driven<'_, T> {
    type Error = DynamicsError;

    fn move_along(&self, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
        integrate(self.model, q, displacement, moved);
    }

    fn accelerate(&mut self, q: &[f64], v: &[f64], acceleration: &mut [f64]) -> Result<(), DynamicsError> {
        let (actuation, memory) = &mut self.actuation;
        let u = self.held.after(actuation, self.times.next().unwrap_or(0.0), self.activations);
        actuation.forces(self.model, memory, u, q, v, self.driven);
        let forces = StepForces::new(self.driven, self.dissipation);
        accelerate(self.model, self.workspace, &forces, self.force, (q, v), acceleration)
    }
}
