//! Actuation in implicit and MuJoCo's steps, and its part in the energy account.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{FrameId, Model, integrate};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::EnergyAccount;

use super::simulate::{Losses, end_energies};
use crate::{Actuation, ActuationWorkspace, StateTransition, StepWorkspace};

clone_in_place! {
    /// Tendons, gravity compensation and actuators, at held controls.
    #[derive(Debug)]
    pub struct StepActuation {
        actuation: Actuation,
        workspace: ActuationWorkspace,
        controls: Vec<f64>,
        /// The actuators' joint torques at the last evaluation.
        torques: Vec<f64>,
        of_step: ActuatorLoad,
        /// The forces of adhesion in the last step, which are held over it.
        adhesion: Vec<f64>,
        driven: Vec<f64>,
        mean: Vec<f64>,
        half: Vec<f64>,
        /// Whether the losses of the scheme contain those of a fluid.
        is_fluid_counted: bool,
    }
}

clone_in_place! {
    /// The forces of the actuators in a step: see [`Stepper::actuator_forces`](crate::Stepper::actuator_forces).
    #[derive(Debug, Default)]
    pub(crate) struct ActuatorLoad {
        /// The force of each actuator \[N·m or N\].
        pub forces: Vec<f64>,
        /// The generalized force on each coordinate \[N·m or N\].
        pub torques: Vec<f64>,
    }
}

impl ActuatorLoad {
    pub(crate) fn new(actuation: &Actuation, nv: usize) -> Self {
        Self { forces: vec![0.0; actuation.control_count()], torques: vec![0.0; nv] }
    }
}

impl StepActuation {
    /// # Panics
    /// Panics if the number of controls differs from the number of actuators.
    #[track_caller]
    pub(crate) fn new(nv: usize, actuation: &Actuation, controls: &[f64]) -> Self {
        actuation.check_controls(controls);
        let zeros = || vec![0.0; nv];
        Self {
            actuation: actuation.clone(),
            workspace: actuation.workspace(),
            controls: controls.to_vec(),
            torques: zeros(),
            of_step: ActuatorLoad::new(actuation, nv),
            adhesion: zeros(),
            driven: zeros(),
            mean: zeros(),
            half: zeros(),
            is_fluid_counted: false,
        }
    }

    /// With the losses of a fluid among those of the scheme.
    pub(crate) fn with_fluid_counted_apart(self) -> Self {
        Self { is_fluid_counted: true, ..self }
    }

    /// The forces of a fluid at the last evaluation, if there is one.
    pub(crate) fn last_fluid_forces(&self) -> Option<&[f64]> {
        self.workspace.last_fluid_forces()
    }

    /// Sets the controls for the next steps.
    ///
    /// # Panics
    /// Panics if the number of controls differs from the number of actuators.
    #[track_caller]
    pub(crate) fn set_controls(&mut self, controls: &[f64]) {
        check_length("the controls", controls.len(), self.controls.len());
        self.controls.copy_from_slice(controls);
    }

    /// The controls.
    pub(crate) fn controls(&mut self) -> &mut [f64] {
        &mut self.controls
    }

    /// The forces at (q, v).
    pub(crate) fn forces(&mut self, model: &Model, q: &[f64], v: &[f64], forces: &mut [f64]) {
        let Self { actuation, workspace, controls, torques, .. } = self;
        actuation.actuator_torques(model, workspace, controls, q, v, torques);
        forces.copy_from_slice(torques);
        actuation.add_passive(model, workspace, (q, v), forces);
    }

    /// Adds ∂f/∂q and ∂f/∂v of the forces at (q, v) without those of a fluid.
    pub(crate) fn add_derivatives(
        &mut self,
        model: &Model,
        state: (&[f64], &[f64]),
        out: (&mut [f64], &mut [f64]),
    ) {
        let Self { actuation, workspace, controls, .. } = self;
        actuation.add_derivatives_without_fluid(model, workspace, controls, state, out);
    }

    /// Writes ∂f/∂u, and returns whether a control is at a bound.
    pub(crate) fn derivatives_by_control(
        &mut self,
        model: &Model,
        state: (&[f64], &[f64]),
        by_control: &mut [f64],
    ) -> bool {
        let Self { actuation, workspace, controls, .. } = self;
        actuation.derivatives_by_control(model, workspace, controls, state, by_control)
    }

    /// Calls `add` with the entries on and below the diagonal of the damping by a fluid at (q, v).
    pub(crate) fn for_each_damping(
        &mut self,
        model: &Model,
        state: (&[f64], &[f64]),
        add: impl FnMut(usize, usize, f64),
    ) {
        self.actuation.for_each_damping(model, &mut self.workspace, state, add);
    }

    /// Stores the actuators' forces of the last evaluation as those of the step.
    pub(crate) fn record_forces(&mut self) {
        self.of_step.forces.copy_from_slice(self.workspace.actuator_forces());
        self.of_step.torques.copy_from_slice(&self.torques);
    }

    /// The links whose contacts actuators pull together, with the forces of the last evaluation.
    pub(crate) fn adhesions(&self) -> impl Iterator<Item = (FrameId, f64)> {
        self.actuation.adhesions(&self.workspace)
    }

    /// Adds the forces of adhesion to those of the step.
    pub(crate) fn record_adhesion(&mut self, forces: &[f64]) {
        self.adhesion.copy_from_slice(forces);
        self.of_step.torques.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
    }

    /// The forces that [`record_forces`](Self::record_forces) stored.
    pub(crate) fn of_step(&self) -> &ActuatorLoad {
        &self.of_step
    }

    /// Takes over the rest positions of springs that yielded.
    pub(crate) fn copy_rest_positions(&mut self, from: &Self) {
        self.actuation.copy_rest_positions(&from.actuation);
    }

    pub(crate) fn actuation(&self) -> &Actuation {
        &self.actuation
    }

    /// The energy stored by springs and gravity compensation \[J\].
    pub(crate) fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.actuation.stored_energy(&mut self.workspace, q)
    }
}

/// The energy stored by the springs and the gravity compensation of a robot that may have actuation \[J\].
pub(crate) fn stored_energy(actuation: &mut Option<StepActuation>, q: &[f64]) -> f64 {
    actuation.as_mut().map_or(0.0, |actuation| actuation.stored_energy(q))
}

/// Records a step in the energy account. `last` holds the losses of the scheme; the function adds those of
/// the drive's dampers to it, and then adds `last` to `losses`.
pub fn record(
    model: &Model,
    workspace: &mut StepWorkspace,
    energy_account: &mut EnergyAccount,
    transition: StateTransition<'_>,
    drive: &mut Option<StepActuation>,
    (last, losses): (&mut Losses, &mut Losses),
) {
    let (kinetic, potential) = end_energies(model, workspace, transition);
    let StateTransition { from, to, forces, h } = transition;
    let StepWorkspace { displacement: way, q: middle, .. } = workspace;
    let mut work: f64 = forces.tau.iter().zip(&*way).map(|(tau, way)| tau * way).sum();
    let mut stored = 0.0;
    if let Some(StepActuation {
        actuation,
        workspace,
        controls,
        torques,
        driven,
        mean,
        half,
        adhesion,
        is_fluid_counted,
        ..
    }) = drive
    {
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
        driven.iter_mut().zip(&*adhesion).for_each(|(sum, force)| *sum += force);
        work += h * driven.iter().zip(&*mean).map(|(tau, v)| tau * v).sum::<f64>();
        last.damping += actuation.dissipated_over(workspace, h, middle, (way, mean));
        if !*is_fluid_counted {
            last.damping += h * actuation.power_into_fluid(model, workspace, (middle, way), mean);
        }
        last.friction += actuation.yield_springs(workspace, to.0);
        stored = actuation.stored_energy(workspace, to.0);
    }
    losses.add(last);
    let dissipated = energy_account.dissipated() + last.total();
    energy_account.enter(kinetic, potential + stored, energy_account.work() + work, dissipated);
}
