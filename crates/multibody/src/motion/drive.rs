//! What drives the robot beside τ in steps that know the actuators, and its books.

use dynamics::EnergyLedger;

use super::simulate::{Losses, travel};
use crate::clone_in_place::clone_in_place;
use crate::model::length::check_length;
use crate::{Actuation, ActuationWorkspace, Model, StepForces, StepWorkspace, integrate};

clone_in_place! {
    /// Tendons, carried weight and actuators, at controls that are held.
    #[derive(Debug)]
    pub(crate) struct Drive {
        actuation: Actuation,
        workspace: ActuationWorkspace,
        controls: Vec<f64>,
        /// The actuators' joint torques where the forces were last computed.
        torques: Vec<f64>,
        of_step: ActuatorLoad,
        driven: Vec<f64>,
        mean: Vec<f64>,
        half: Vec<f64>,
    }
}

clone_in_place! {
    /// The forces of the actuators in a step: see [`Stepper::actuator_forces`](crate::Stepper::actuator_forces).
    #[derive(Debug, Default)]
    pub(crate) struct ActuatorLoad {
        /// One entry for each actuator \[N·m or N\].
        pub(crate) forces: Vec<f64>,
        /// On each coordinate \[N·m or N\].
        pub(crate) torques: Vec<f64>,
    }
}

impl ActuatorLoad {
    pub(crate) fn new(actuation: &Actuation, nv: usize) -> Self {
        Self { forces: vec![0.0; actuation.control_count()], torques: vec![0.0; nv] }
    }
}

impl Drive {
    /// # Panics
    /// If there is not one control for each actuator.
    #[track_caller]
    pub(crate) fn new(nv: usize, actuation: &Actuation, controls: &[f64]) -> Self {
        check_length("the controls", controls.len(), actuation.control_count());
        let zeros = || vec![0.0; nv];
        Self {
            actuation: actuation.clone(),
            workspace: actuation.workspace(),
            controls: controls.to_vec(),
            torques: zeros(),
            of_step: ActuatorLoad::new(actuation, nv),
            driven: zeros(),
            mean: zeros(),
            half: zeros(),
        }
    }

    /// Holds these controls from now on.
    ///
    /// # Panics
    /// If there is not one control for each actuator.
    #[track_caller]
    pub(crate) fn set_controls(&mut self, controls: &[f64]) {
        check_length("the controls", controls.len(), self.controls.len());
        self.controls.copy_from_slice(controls);
    }

    /// The forces at (q, v).
    pub(crate) fn forces(&mut self, model: &Model, q: &[f64], v: &[f64], forces: &mut [f64]) {
        let Self { actuation, workspace, controls, torques, .. } = self;
        actuation.actuator_torques(model, workspace, controls, q, v, torques);
        forces.copy_from_slice(torques);
        actuation.add_passive(workspace, q, v, forces);
    }

    /// Takes what the actuators gave at the last state that was looked at as what they gave in the step.
    pub(crate) fn note_step(&mut self) {
        self.of_step.forces.copy_from_slice(self.workspace.actuator_forces());
        self.of_step.torques.copy_from_slice(&self.torques);
    }

    /// As [`note_step`](Self::note_step) left it.
    pub(crate) fn of_step(&self) -> &ActuatorLoad {
        &self.of_step
    }

    pub(crate) fn actuation(&self) -> &Actuation {
        &self.actuation
    }

    /// What springs and carried weight store \[J\].
    pub(crate) fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.actuation.stored_energy(&mut self.workspace, q)
    }
}

/// Enters a step into the books, with the losses that its scheme has in `last`; these then hold what the drive's dampers took, too, and are
/// added to `losses`.
pub(crate) fn record(
    model: &Model,
    workspace: &mut StepWorkspace,
    ledger: &mut EnergyLedger,
    [from, to]: [(&[f64], &[f64]); 2],
    (forces, h): (&StepForces<'_>, f64),
    drive: &mut Option<Drive>,
    (last, losses): (&mut Losses, &mut Losses),
) {
    let (kinetic, potential) = travel(model, workspace, from, to, h);
    let StepWorkspace { displacement: way, q: middle, .. } = workspace;
    let mut work: f64 = forces.tau.iter().zip(&*way).map(|(tau, way)| tau * way).sum();
    let mut stored = 0.0;
    if let Some(Drive { actuation, workspace, controls, torques, driven, mean, half, .. }) = drive {
        // The impulse of forces that are linear in q and v, hf(q̄, Δq/h), times the mean velocity.
        for k in 0..way.len() {
            half[k] = 0.5 * way[k];
            mean[k] = 0.5 * (from.1[k] + to.1[k]);
            way[k] /= h;
        }
        integrate(model, from.0, half, middle);
        actuation.actuator_torques(model, workspace, controls, middle, way, torques);
        driven.copy_from_slice(torques);
        actuation.add_unstored(workspace, driven);
        work += h * driven.iter().zip(&*mean).map(|(tau, v)| tau * v).sum::<f64>();
        last.damping += actuation.dissipated_over(h, middle, way, mean);
        stored = actuation.stored_energy(workspace, to.0);
    }
    losses.add(last);
    let dissipated = ledger.dissipated() + last.total();
    ledger.enter(kinetic, potential + stored, ledger.work() + work, dissipated);
}
