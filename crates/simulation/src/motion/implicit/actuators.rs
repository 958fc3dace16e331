//! Actuators of a step.

use robot_dynamics_core::Model;

use super::ImplicitIntegrator;
use crate::Actuation;
use crate::motion::step_actuation::StepActuation;

impl ImplicitIntegrator {
    /// Adds tendons, gravity compensation, a fluid and actuators at these controls ([`Actuation`]); their
    /// stiffness and damping are implicit. Lift and added mass of a fluid are explicit.
    ///
    /// # Panics
    /// Panics if the number of controls differs from the number of actuators.
    #[track_caller]
    pub(crate) fn with_actuation(mut self, model: &Model, actuation: &Actuation, controls: &[f64]) -> Self {
        self.joints.add_gains(model, actuation);
        self.factor.couple(self.joints.couplings());
        self.components.unite(self.joints.couplings().iter().map(|coupling| &coupling.row[..]));
        self.resize_trees();
        let actuation = actuation.clone().without_joint_tendon_friction();
        let drive = StepActuation::new(self.memory.force.len(), &actuation, controls);
        self.drive = Some(drive.with_fluid_counted_apart());
        self
    }

    /// Takes over the rest positions of springs that yielded.
    pub(crate) fn copy_rest_positions(&mut self, from: &Self) {
        if let (Some(own), Some(from)) = (&mut self.drive, &from.drive) {
            own.copy_rest_positions(from);
        }
    }

    /// Sets the controls for the next steps, if there are actuators.
    #[track_caller]
    pub(crate) fn set_controls(&mut self, controls: &[f64]) {
        if let Some(drive) = &mut self.drive {
            drive.set_controls(controls);
        }
    }
}
