//! The start and the end of a step: checks and limits of inputs, activations, mean acceleration.

use robot_dynamics_number::check_number;

use super::Simulation;
use super::memory::SimulationMemory;
use crate::RunError;
use crate::motion::simulate::{RunLoop, check_input_torque};

impl Simulation {
    /// Checks the inputs, clips torques to their limits, and converts wrenches to generalized forces.
    pub(super) fn begin_step(&mut self, course: &RunLoop<'_>) -> Result<(), RunError> {
        let Self { model, inputs, run, memory, effort, workspace, .. } = self;
        let refused = |source| RunError::StepInput { step: run.steps, time: course.time(run.steps), source };
        check_input_torque(model, &inputs.torques).map_err(refused)?;
        memory.tau.copy_from_slice(&inputs.torques);
        if let Some(effort) = effort {
            for (tau, limit) in memory.tau.iter_mut().zip(effort.iter()) {
                *tau = tau.clamp(-limit.max(0.0), limit.max(0.0));
            }
        }
        memory.applied.copy_from_slice(&memory.tau);
        for wrench in &inputs.wrenches {
            wrench.check(model).map_err(refused)?;
            let SimulationMemory { jacobian, applied, .. } = memory;
            wrench.add_to(model, workspace.dynamics(), &run.q, jacobian, applied);
        }
        if let Some(actuation) = &self.actuation {
            if let Some(index) = inputs.controls.iter().position(|control| !control.is_finite()) {
                let name = actuation.control_names().nth(index).unwrap_or_default();
                let checked =
                    check_number(&format!("the control of actuator `{name}`"), inputs.controls[index]);
                checked.map_err(refused)?;
            }
            let half = 0.5 * self.step;
            actuation.activate(&inputs.controls, 0.0, &mut self.activations);
            memory.middle.copy_from_slice(&self.activations);
            actuation.activate(&inputs.controls, half, &mut memory.middle);
            let SimulationMemory { states, middle, .. } = memory;
            if let Some(states) = states {
                let activations = (&self.activations[..], &mut middle[..]);
                states.begin((model, actuation), (&run.q, &run.v), half, activations);
            }
            self.stepper.set_controls(&inputs.controls, &self.activations, &memory.middle);
        }
        Ok(())
    }

    /// The rank at the start of a run was checked when the state was set.
    pub(super) fn check_mass(&mut self, course: &RunLoop<'_>) -> Result<(), RunError> {
        let steps = self.run.steps;
        if !core::mem::replace(&mut self.is_checked, false) {
            let checked = course.check_mass(&mut self.stepper, &mut self.workspace, &self.run.q, steps);
            checked.map_err(|error| course.named(&self.stepper, &self.run, error))?;
        }
        Ok(())
    }

    /// Counts the clipped torques, and advances the activations by the step's length \[s\].
    pub(super) fn end_step(&mut self, length: f64) {
        let Self { model, limited, inputs, memory, activations, stepper, run, .. } = self;
        for (k, count) in limited.iter_mut().enumerate() {
            *count += usize::from(memory.tau[k] != inputs.torques[k]);
        }
        if let Some(actuation) = &self.actuation {
            let SimulationMemory { states, middle, .. } = memory;
            if let Some(states) = states {
                let activations = (&mut activations[..], &middle[..]);
                states.end((model, actuation), (stepper, length), (&run.q, &run.v), activations);
            }
            actuation.activate(&inputs.controls, length, activations);
        }
    }
}
