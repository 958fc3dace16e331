//! The results of a run, and the loop of its steps with their checks.

use robot_dynamics_core::{Model, SingularMass, check_configuration, check_vector};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{EnergyAccount, IntegratorError};
use robot_dynamics_number::check_positive;

use super::energy_account::{fastest, open_start};
use super::results::Run;
use super::{RunError, StepError, Stepper, Trajectory};
use crate::{StateTransition, StepForces, StepWorkspace};

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
    ) -> (Run, Result<(), RunError>) {
        let model = self.model;
        check_length("v0", v0.len(), model.nv());
        let start = self.check_start(stepper, workspace, (q0, v0), steps);
        let overflow = |fastest, _| self.blow_up("the energy", fastest, 0);
        let (energy_account, q, v, start) =
            open_start(model, &mut workspace.dynamics, q0, v0, start, overflow);
        let stored = stepper.stored_energy(&q);
        let run = Run {
            energy_account: EnergyAccount::new(energy_account.kinetic(), energy_account.potential() + stored),
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
    ) -> Result<(), RunError> {
        check_positive("the step", self.step, "s")?;
        check_configuration(self.model, q0)?;
        check_vector(self.model, "v", v0)?;
        stepper
            .check_start(self.model, &mut workspace.dynamics, self.step, q0, v0)
            .map_err(|error| self.step_failed(error, 0))?;
        if steps == 0 { Ok(()) } else { self.check_mass(stepper, workspace, q0, 0) }
    }

    /// Takes one step of `h` \[s\] from the current state to (q, v), and returns the energy account after it.
    pub fn take_step<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        run: &Run,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<EnergyAccount, RunError> {
        let taken = self.take_step_unnamed(stepper, workspace, run, forces, h, (q, &mut *v));
        let energy_account = taken.map_err(|error| self.named(stepper, run, error))?;
        if self.is_lost(v) { Err(self.diverged(stepper, run, v, run.steps + 1)) } else { Ok(energy_account) }
    }

    fn take_step_unnamed<S: Stepper>(
        &self,
        stepper: &mut S,
        workspace: &mut StepWorkspace,
        run: &Run,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<EnergyAccount, RunError> {
        let (model, done) = (self.model, run.steps);
        q.copy_from_slice(&run.q);
        v.copy_from_slice(&run.v);
        stepper.step(model, workspace, forces, h, q, v).map_err(|error| self.step_failed(error, done))?;
        self.check_state(q, v, done + 1)?;
        let mut energy_account = run.energy_account;
        let transition = StateTransition { from: (&run.q, &run.v), to: (q, v), forces, h };
        stepper.record(model, workspace, &mut energy_account, transition);
        if !energy_account.imbalance().is_finite() {
            return Err(self.blow_up("the energy", fastest(v), done + 1));
        }
        Ok(energy_account)
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
    ) -> Result<(), RunError> {
        stepper
            .check_mass(self.model, &mut workspace.dynamics, q)
            .map_err(|source| self.singular(source, step))
    }

    fn singular(&self, source: SingularMass, step: usize) -> RunError {
        RunError::SingularMass { step, time: self.time(step), source }
    }

    fn check_state(&self, q: &[f64], v: &[f64], step: usize) -> Result<(), RunError> {
        if let Some(index) = first_not_finite(v) {
            return Err(self.blow_up("v", index, step));
        }
        let Some(index) = first_not_finite(q) else { return Ok(()) };
        Err(self.blow_up("q", self.first_coordinate_of(index), step))
    }

    /// The first entry in v of the joint that owns this entry of q.
    fn first_coordinate_of(&self, index: usize) -> usize {
        let owner = self.model.joints().iter().find(|j| j.q().contains(&index));
        owner.map_or(0, |joint| joint.v_index)
    }

    pub(crate) fn blow_up(&self, quantity: &'static str, index: usize, step: usize) -> RunError {
        let coordinate = self.model.coordinate_names().get(index).cloned().unwrap_or_default();
        RunError::NotFinite { quantity, coordinate, step, time: self.time(step) }
    }

    fn step_failed(&self, error: StepError, step: usize) -> RunError {
        match error {
            StepError::Integrator(IntegratorError::NotFinite { quantity, index }) => {
                let index = if quantity.starts_with('q') { self.first_coordinate_of(index) } else { index };
                self.blow_up(quantity, index, step)
            }
            // Inside the step.
            StepError::Integrator(IntegratorError::SingularMass { coordinate, pivot }) => {
                self.singular(SingularMass::at(self.model, coordinate, pivot), step)
            }
            StepError::SingularMass(source) => self.singular(source, step),
            source => RunError::Step { step, time: self.time(step), source },
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
