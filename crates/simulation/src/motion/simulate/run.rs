//! The results of a run, and the loop of its steps with their checks.

use std::ops::ControlFlow;

use robot_dynamics_core::{Model, SingularMass, check_configuration};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::EnergyLedger;
use robot_dynamics_number::check_positive;

use super::ledger::{fastest, open_start};
use super::{EventOccurrence, Losses, RunError, StepError, StepFault, Stepper, Trajectory};
use crate::{ContactLaws, StepForces, StepWorkspace};

/// The state that an observer receives: at a control instant, before the torque acts.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
#[doc(alias = "Moment")]
pub struct StepInfo<'a> {
    /// Completed steps.
    pub step: usize,
    /// Time since the start \[s\].
    pub time: f64,
    /// The configuration.
    pub q: &'a [f64],
    /// The velocity.
    pub v: &'a [f64],
    /// The torque of the controller at this state \[N·m or N\].
    pub tau: &'a [f64],
    /// The current energy account.
    pub ledger: &'a EnergyLedger,
    /// The energy dissipated so far, by cause; `None` if the method does not separate the causes.
    pub losses: Option<Losses>,
    /// The force of the ground on each link that can touch it, along the world's axes, as the mean of the
    /// step before \[N\]. The order is that of [`ContactSet::links`](crate::ContactSet::links); empty if
    /// contact is not computed.
    pub contact_forces: &'a [[f64; 3]],
    /// The force of each actuator before its gear, as the mean of the step before \[N·m or N\]:
    /// [`Stepper::actuator_forces`]. Empty if the method has no actuators.
    pub actuator_forces: &'a [f64],
    /// The generalized force of the actuators, as the mean of the step before \[N·m or N\]:
    /// [`Stepper::actuator_torques`].
    pub actuator_torques: &'a [f64],
}

/// The results of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Run {
    /// The samples.
    pub trajectory: Trajectory,
    /// The energy account.
    pub ledger: EnergyLedger,
    /// The dissipated energy by cause, if the method separates the causes; the sum is
    /// [`EnergyLedger::dissipated`].
    pub losses: Option<Losses>,
    /// The largest |τ| that acted on each coordinate \[N·m or N\].
    pub peak_torque: Vec<f64>,
    /// The events, sorted by time.
    pub events: Vec<EventOccurrence>,
    /// Completed steps; a last step that a terminal event shortened counts as one.
    pub steps: usize,
    /// The end time since the start \[s\].
    pub time: f64,
    /// Whether the observer or an interrupt flag ended the run early
    /// ([`SimulationBuilder::interrupt`](crate::simulator::SimulationBuilder::interrupt)).
    pub interrupted: bool,
    /// Whether a terminal event ended the run; it is the last of [`events`](Self::events).
    pub ended_by_event: bool,
    /// The accuracy of the solutions of rigid contact, if the method solves for them.
    pub contact_laws: Option<ContactLaws>,
    /// The last of [`StepInfo::contact_forces`].
    pub contact_forces: Vec<[f64; 3]>,
    /// q at the end.
    pub q: Vec<f64>,
    /// v at the end.
    pub v: Vec<f64>,
}

impl Run {
    /// The observer's view of the current state, after a number of steps.
    pub(crate) fn step_info<'a>(
        &'a self,
        step: usize,
        tau: &'a [f64],
        stepper: &'a impl Stepper,
    ) -> StepInfo<'a> {
        StepInfo {
            step,
            time: self.time,
            q: &self.q,
            v: &self.v,
            tau,
            ledger: &self.ledger,
            losses: self.losses,
            contact_forces: stepper.contact_forces(),
            actuator_forces: stepper.actuator_forces(),
            actuator_torques: stepper.actuator_torques(),
        }
    }

    /// Adds the current state to the samples.
    pub(crate) fn keep_sample(&mut self, tau: &[f64], stepper: &impl Stepper) {
        let Self { trajectory, time, q, v, ledger, .. } = self;
        trajectory.push(*time, (q, v), tau, ledger, stepper.contact_forces());
    }
}

/// A callback that receives the state at the start of each step and at the end, and can stop the run.
pub type Observer<'a> = &'a mut dyn FnMut(&StepInfo<'_>) -> ControlFlow<()>;

/// The steps of a run by any method.
pub struct RunLoop<'a> {
    pub model: &'a Model,
    pub step: f64,
    pub dissipation: bool,
    pub sample_every: usize,
    /// The last reset of the step count: the first step after a shortened step, and its time \[s\].
    pub base: (usize, f64),
}

impl RunLoop<'_> {
    /// Opens the run, and checks its start. An invalid start is replaced by the neutral configuration at
    /// rest.
    #[track_caller]
    pub(crate) fn open<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        (q0, v0): (&[f64], &[f64]),
        steps: usize,
    ) -> (Run, Result<(), RunError<S::Error>>) {
        let model = self.model;
        check_length("v0", v0.len(), model.nv());
        let start = self.check_start(stepper, workspace, (q0, v0), steps);
        let overflow = |fastest, _| self.blow_up("the energy", fastest, 0);
        let (ledger, q, v, start) = open_start(model, &mut workspace.dynamics, q0, v0, start, overflow);
        let stored = stepper.stored_energy(&q);
        let run = Run {
            ledger: EnergyLedger::new(ledger.kinetic(), ledger.potential() + stored),
            trajectory: Trajectory::new(model, self.samples_of(steps)),
            losses: stepper.losses(),
            peak_torque: vec![0.0; model.nv()],
            events: Vec::new(),
            steps: 0,
            time: self.base.1,
            interrupted: false,
            ended_by_event: false,
            contact_laws: stepper.contact_laws(),
            contact_forces: stepper.contact_forces().to_vec(),
            q,
            v,
        };
        (run, start)
    }

    fn check_start<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        (q0, v0): (&[f64], &[f64]),
        steps: usize,
    ) -> Result<(), RunError<S::Error>> {
        check_positive("the step", self.step, "s")?;
        check_configuration(self.model, q0)?;
        if let Some(index) = v0.iter().position(|v| !v.is_finite()) {
            return Err(self.blow_up("v", index, 0));
        }
        stepper
            .check_start(self.model, &mut workspace.dynamics, self.step, q0, v0)
            .map_err(|error| self.step_failed(error, 0))?;
        if steps == 0 { Ok(()) } else { self.check_mass(stepper, workspace, q0, 0) }
    }

    /// Takes one step of `h` \[s\] from the current state to (q, v), and returns the energy account after it.
    pub fn take<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        run: &Run,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<EnergyLedger, RunError<S::Error>> {
        let taken = self.take_unnamed(stepper, workspace, run, forces, h, (q, &mut *v));
        let ledger = taken.map_err(|error| self.named(stepper, run, error))?;
        if self.is_lost(v) { Err(self.diverged(stepper, run, v, run.steps + 1)) } else { Ok(ledger) }
    }

    fn take_unnamed<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        run: &Run,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<EnergyLedger, RunError<S::Error>> {
        let (model, done) = (self.model, run.steps);
        q.copy_from_slice(&run.q);
        v.copy_from_slice(&run.v);
        stepper.step(model, workspace, forces, h, q, v).map_err(|error| self.step_failed(error, done))?;
        self.check_state(q, v, done + 1)?;
        let mut ledger = run.ledger;
        stepper.record(model, workspace, &mut ledger, (&run.q, &run.v), (q, v), forces, h);
        if !ledger.imbalance().is_finite() {
            return Err(self.blow_up("the energy", fastest(v), done + 1));
        }
        Ok(ledger)
    }

    pub fn time(&self, step: usize) -> f64 {
        self.base.1 + (step - self.base.0) as f64 * self.step
    }

    pub fn check_mass<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        q: &[f64],
        step: usize,
    ) -> Result<(), RunError<S::Error>> {
        stepper
            .check_mass(self.model, &mut workspace.dynamics, q)
            .map_err(|source| self.singular(source, step))
    }

    fn singular<E>(&self, source: SingularMass, step: usize) -> RunError<E> {
        RunError::SingularMass { step, time: self.time(step), source }
    }

    fn check_state<E>(&self, q: &[f64], v: &[f64], step: usize) -> Result<(), RunError<E>> {
        if let Some(index) = first_not_finite(v) {
            return Err(self.blow_up("v", index, step));
        }
        let Some(index) = first_not_finite(q) else { return Ok(()) };
        Err(self.blow_up("q", self.first_coordinate_of(index), step))
    }

    /// The first entry in v of the joint that owns this entry of q.
    fn first_coordinate_of(&self, index: usize) -> usize {
        let owner = self.model.joints().iter().find(|j| (j.q_index..j.q_index + j.nq).contains(&index));
        owner.map_or(0, |joint| joint.v_index)
    }

    pub(crate) fn blow_up<E>(&self, quantity: &'static str, index: usize, step: usize) -> RunError<E> {
        let coordinate = self.model.coordinate_names().get(index).cloned().unwrap_or_default();
        RunError::NotFinite { quantity, coordinate, step, time: self.time(step) }
    }

    fn step_failed<E: StepError>(&self, error: E, step: usize) -> RunError<E> {
        match error.fault(self.model) {
            StepFault::NotFinite { quantity, index } => {
                let index = if quantity.starts_with('q') { self.first_coordinate_of(index) } else { index };
                self.blow_up(quantity, index, step)
            }
            // Inside the step.
            StepFault::SingularMass(source) => self.singular(source, step),
            StepFault::Other(source) => RunError::Step { step, time: self.time(step), source },
        }
    }

    /// The number of samples that a run keeps. Memory for up to a million is reserved at once, and grows for
    /// more.
    pub(crate) fn samples_of(&self, steps: usize) -> usize {
        (steps.checked_div(self.sample_every).unwrap_or(0) + 2).min(1_000_000)
    }
}

// Not generic, so that it is compiled once in this crate.

fn first_not_finite(x: &[f64]) -> Option<usize> {
    x.iter().position(|x| !x.is_finite())
}
