//! An interface for steps that are computed for several simulations at once.

use std::sync::Arc;

use robot_dynamics_core::InstructionSet;
use robot_dynamics_integrators::Integrator;

use super::{Method, Simulation};
use crate::motion::simulate::RunLoop;
use crate::motion::simulate::energy_account::{StateTransition, record_energies};
use crate::{RunError, StepForces};

/// The start of a step.
#[doc(hidden)]
pub struct StepStart<'a> {
    pub q: &'a [f64],
    pub v: &'a [f64],
    /// The torques after effort limits.
    pub tau: &'a [f64],
}

impl Simulation {
    /// The explicit row that takes the next steps, whether damping and friction act, and the step \[s\].
    /// `None` for other methods, under wrenches or actuation, and if only portable instructions are
    /// available.
    pub fn explicit_row(&self) -> Option<(Integrator, bool, f64)> {
        let Method::Fixed(_) = self.method() else { return None };
        let row = self.stepper.row().filter(|row| row.is_explicit())?;
        let is_plain = self.inputs.wrenches.is_empty()
            && self.actuation.is_none()
            && self.workspace.dynamics.instruction_set() != InstructionSet::Portable;
        is_plain.then_some((row, self.dissipates, self.step))
    }

    /// Checks the torques and clips them to their limits; they are held over the following steps.
    ///
    /// # Errors
    /// A torque is not finite.
    pub fn begin_external_steps(&mut self) -> Result<(), RunError> {
        let model = Arc::clone(&self.model);
        self.begin_step(&self.run_loop(&model, 0, self.base))
    }

    /// Checks the rank of M at the start of a step.
    ///
    /// # Errors
    /// M is singular.
    pub fn check_external_step(&mut self) -> Result<(), RunError> {
        let model = Arc::clone(&self.model);
        self.check_mass(&self.run_loop(&model, 0, self.base))
    }

    /// The start of the next step.
    pub fn step_start(&self) -> StepStart<'_> {
        StepStart { q: &self.run.q, v: &self.run.v, tau: &self.memory.applied }
    }

    /// Records a step to (q, v) that was computed elsewhere, with K and V at its end \[J\]. Returns false,
    /// and changes nothing, for a step that [`step`](Self::step) would reject.
    pub fn record_external_step(&mut self, (q, v): (&[f64], &[f64]), energies: (f64, f64)) -> bool {
        let Self { model, run, memory, stepper, workspace, .. } = self;
        let mut energy_account = run.energy_account;
        let forces = StepForces::new(&memory.applied, self.dissipates);
        let start = (&run.q[..], &run.v[..]);
        let transition = StateTransition { from: start, to: (q, v), forces: &forces, h: self.step };
        record_energies(model, workspace, &mut energy_account, transition, energies);
        let course = RunLoop {
            model,
            step: self.step,
            dissipation: self.dissipates,
            sample_every: 0,
            base: self.base,
        };
        let is_good = q.iter().chain(v).all(|x| x.is_finite());
        if !is_good || course.is_lost(v) || !energy_account.imbalance().is_finite() {
            return false;
        }
        memory.before.copy_from_slice(&run.v);
        memory.q.copy_from_slice(q);
        memory.v.copy_from_slice(v);
        memory.record_acceleration(self.step);
        let end = course.time(run.steps + 1);
        RunLoop::enter(run, stepper, (energy_account, end), (q, v));
        self.end_step(self.step);
        self.is_checked = false;
        true
    }
}
