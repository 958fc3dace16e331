//! Steps of a simulation that are computed beside those of others.

use std::sync::Arc;

use dynamics::Integrator;

use super::error::StepFailure;
use super::step_inputs::note_acceleration;
use super::{Method, Simulation};
use crate::motion::simulate::Course;
use crate::motion::simulate::ledger::record_energies;
use crate::{InstructionSet, Model, StepForces};

/// The start of a step.
pub(crate) struct StepStart<'a> {
    pub q: &'a [f64],
    pub v: &'a [f64],
    /// The torques within their limits.
    pub tau: &'a [f64],
}

impl Simulation {
    /// The robot, which its copies share.
    pub(crate) fn shared_model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The row of explicit stages that takes the next steps with held torques alone, damping and friction beside it; the step \[s\].
    pub(crate) fn explicit_row(&self) -> Option<(Integrator, bool, f64)> {
        let Method::Fixed(_) = self.method() else { return None };
        let row = self.stepper.row().filter(|row| row.is_explicit())?;
        let is_plain = self.inputs.wrenches.is_empty()
            && self.actuation.is_none()
            && self.workspace.dynamics.instruction_set() != InstructionSet::Portable;
        is_plain.then_some((row, self.dissipates, self.step))
    }

    /// Checks the torques and cuts them off at their limits; they are held over the steps that follow.
    pub(crate) fn begin_steps_elsewhere(&mut self) -> Result<(), StepFailure> {
        let model = Arc::clone(&self.model);
        self.begin_step(&self.course(&model, 0, self.base))
    }

    /// Looks at M where a step starts.
    pub(crate) fn check_step_elsewhere(&mut self) -> Result<(), StepFailure> {
        let model = Arc::clone(&self.model);
        self.check_mass(&self.course(&model, 0, self.base))
    }

    /// Where the next step starts.
    pub(crate) fn step_start(&self) -> StepStart<'_> {
        StepStart { q: &self.run.q, v: &self.run.v, tau: &self.memory.applied }
    }

    /// Enters a step that was taken elsewhere, to (q, v). Refuses one that [`step`](Self::step) would refuse: then all is as before.
    /// K and V are those of its end \[J\].
    pub(crate) fn end_step_elsewhere(&mut self, (q, v): (&[f64], &[f64]), energies: (f64, f64)) -> bool {
        let Self { model, run, memory, stepper, workspace, .. } = self;
        let mut ledger = run.ledger;
        let forces = StepForces::new(&memory.applied, self.dissipates);
        let start = (&run.q[..], &run.v[..]);
        record_energies(model, workspace, &mut ledger, start, (q, v), &forces, self.step, energies);
        let course =
            Course { model, step: self.step, dissipation: self.dissipates, sample_every: 0, base: self.base };
        let is_good = q.iter().chain(v).all(|x| x.is_finite());
        if !is_good || course.is_lost(v) || !ledger.imbalance().is_finite() {
            return false;
        }
        memory.before.copy_from_slice(&run.v);
        memory.q.copy_from_slice(q);
        memory.v.copy_from_slice(v);
        note_acceleration(memory, self.step);
        let end = course.time(run.steps + 1);
        Course::enter(run, stepper, (ledger, end), (q, v));
        self.end_step(self.step);
        self.is_checked = false;
        true
    }
}
