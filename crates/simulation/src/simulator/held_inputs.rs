//! The inputs that the stepper of a simulation holds: controls, and rest positions of springs that yielded.

use super::method::{SimulationStepper, StepperKind};

impl SimulationStepper {
    /// Holds controls over the next step. Each stepper uses the activations that it evaluates: at the step's
    /// start, at its middle, or along the step.
    pub(super) fn set_controls(&mut self, controls: &[f64], start: &[f64], middle: &[f64]) {
        match &mut self.kind {
            StepperKind::Actuated(stepper) => stepper.set_controls(controls, start),
            StepperKind::Implicit(stepper) => stepper.set_controls(middle),
            StepperKind::Mujoco(stepper) => stepper.set_controls(start),
            #[cfg(feature = "adaptive")]
            StepperKind::Adaptive(stepper) => stepper.set_controls(controls, start),
            _ => {}
        }
    }

    /// Holds controls over the next step, for actuators whose activation is their control. Methods without
    /// actuators ignore them.
    ///
    /// # Panics
    /// If the number of controls is wrong.
    #[track_caller]
    pub fn hold_controls(&mut self, controls: &[f64]) {
        self.set_controls(controls, controls, controls);
    }

    /// Takes over the rest positions of springs that yielded, from a stepper of the same method.
    pub(super) fn copy_rest_positions(&mut self, from: Option<&Self>) {
        let Some(from) = from else { return };
        match (&mut self.kind, &from.kind) {
            (StepperKind::Actuated(own), StepperKind::Actuated(from)) => own.copy_rest_positions(from),
            (StepperKind::Implicit(own), StepperKind::Implicit(from)) => own.copy_rest_positions(from),
            (StepperKind::Mujoco(own), StepperKind::Mujoco(from)) => own.copy_rest_positions(from),
            _ => {}
        }
    }
}
