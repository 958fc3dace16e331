//! The forces at a state, and the activations.

use robot_dynamics_core::{FrameId, Model, gravity};
use robot_dynamics_description::{Activation, ActuatorDescription, Affine, check_length};

use super::Actuation;
use super::controller_memory::ControllerInputs;
use super::tendon::Tendon;
use super::tendon_law::TendonLaw;
use super::transmission::Drive;
use super::workspace::ActuationWorkspace;

impl Actuation {
    /// Returns τ of tendons, actuators, carried weight and fluid together, nv entries \[N·m or N\]. `u` holds
    /// each actuator's control, or its activation if it has one. Controls are limited to their ranges here.
    /// Then it holds the states of controllers and motors ([`activation_count`](Self::activation_count)),
    /// which are 0 if they are not given.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model belongs to another robot.
    #[track_caller]
    pub fn forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) {
        self.actuator_torques(model, workspace, u, q, v, tau);
        self.add_passive(model, workspace, (q, v), tau);
    }

    /// [`forces`](Self::forces) without those of the fluid.
    pub(super) fn forces_without_fluid(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        (q, v): (&[f64], &[f64]),
        tau: &mut [f64],
    ) {
        self.actuator_torques(model, workspace, u, q, v, tau);
        self.add_tendons(workspace, q, v, tau);
        self.add_weight(workspace, tau);
    }

    /// Adds the forces of tendons, springs and the fluid, and the carried weight that
    /// [`actuator_torques`](Self::actuator_torques) computed at this state and leaves out.
    pub(crate) fn add_passive(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        (q, v): (&[f64], &[f64]),
        tau: &mut [f64],
    ) {
        self.add_tendons(workspace, q, v, tau);
        self.add_weight(workspace, tau);
        if let Some(fluid) = self.fluid_forces(model, workspace, q, v) {
            tau.iter_mut().zip(fluid).for_each(|(tau, fluid)| *tau += fluid);
        }
    }

    /// Returns τ without actuators: springs, damping and friction outside the tree, the carried weight, and
    /// the forces of the fluid, nv entries.
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn passive_forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) {
        self.check(model, q, v, tau);
        self.carry(workspace, q);
        self.place_tendons(workspace, q);
        tau.fill(0.0);
        self.add_passive(model, workspace, (q, v), tau);
    }

    /// Returns τ of the actuators, with the carried weight if it comes from them, within the bounds of joints
    /// and tendons.
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn actuator_torques(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) {
        self.check(model, q, v, tau);
        self.check_controls(u);
        self.evaluate(model, workspace, u, q, v);
        self.carry(workspace, q);
        tau.fill(0.0);
        for (k, (_, drive)) in self.actuators.iter().enumerate() {
            let force = workspace.forces[k];
            drive.spread(model, &self.tendons, &mut workspace.transmissions, q, force, tau);
        }
        for &k in &self.by_actuators {
            tau[k] += workspace.weight[k];
        }
        for &(k, range) in &self.bounded {
            tau[k] = within(tau[k], range);
        }
    }

    /// Returns each actuator's own f \[N·m or N\] at a state, within its range and its tendon's.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut motor = ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0));
    /// motor.force_range = [-2.0, 2.0];
    /// robot.actuators.push(motor);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let mut force = [0.0];
    /// actuation.actuator_forces(&model, &mut actuation.workspace(), &[7.0], &[0.0], &[0.0], &mut force);
    /// assert_eq!(force, [2.0]); // before the gear
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn actuator_forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        forces: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the actuation");
        check_length("the controls", u.len(), self.actuators.len());
        check_length("the forces", forces.len(), self.actuators.len());
        self.evaluate(model, workspace, u, q, v);
        forces.copy_from_slice(&workspace.forces);
    }

    /// Calls `add` with the entries of the damping by the fluid at (q, v): see
    /// [`FluidForces::for_each_damping`](crate::FluidForces).
    pub(crate) fn for_each_damping(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        state: (&[f64], &[f64]),
        add: impl FnMut(usize, usize, f64),
    ) {
        if let Some(fluid) = &self.fluid {
            let memory = workspace.fluid.get_or_insert_with(|| fluid.workspace(model));
            fluid.for_each_damping(model, memory, state, add);
        }
    }

    /// The generalized forces of the fluid, if there is one.
    pub(super) fn fluid_forces<'w>(
        &self,
        model: &Model,
        workspace: &'w mut ActuationWorkspace,
        q: &[f64],
        v: &[f64],
    ) -> Option<&'w [f64]> {
        let fluid = self.fluid.as_ref()?;
        let memory = workspace.fluid.get_or_insert_with(|| fluid.workspace(model));
        Some(fluid.compute(model, memory, q, v))
    }

    /// Advances the activations by h \[s\] with constant controls, exactly
    /// ([`Activation::after`](robot_dynamics_description::Activation::after)). They stop at the bounds of
    /// their ranges. Without activation dynamics, an activation equals its control. States of controllers and
    /// motors depend on the motion and do not change here.
    ///
    /// ```
    /// use robot_dynamics::description::{Activation, ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut motor = ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0));
    /// motor.activation = Activation::Filter { time_constant: 0.5 };
    /// robot.actuators.push(motor);
    /// let actuation = Actuation::new(&Model::new(robot)?)?;
    /// let mut activation = [0.0];
    /// actuation.activate(&[1.0], 0.5, &mut activation);
    /// assert!((activation[0] - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn activate(&self, controls: &[f64], h: f64, activations: &mut [f64]) {
        check_length("the controls", controls.len(), self.actuators.len());
        if activations.len() != self.actuators.len() {
            check_length("the activations", activations.len(), self.activation_count());
        }
        for (k, (actuator, drive)) in self.actuators.iter().enumerate() {
            let control = within(controls[k], actuator.control_range);
            let control = match actuator.activation {
                Activation::RateLimit { .. } => nearest_setpoint(actuator, drive, control, activations[k]),
                _ => control,
            };
            let after = actuator.activation.after(h, control, activations[k]);
            activations[k] = match actuator.activation {
                Activation::None => after,
                _ => within(after, actuator.activation_range),
            };
        }
    }

    /// Adds the carried weight that neither [`actuator_torques`](Self::actuator_torques), called before, nor
    /// [`stored_energy`](Self::stored_energy) includes.
    pub(crate) fn add_unstored(&self, workspace: &ActuationWorkspace, tau: &mut [f64]) {
        if !self.by_actuators.is_empty() {
            self.add_weight(workspace, tau);
        }
    }

    /// Adds the forces of tendons and springs without actuators.
    fn add_tendons(&self, workspace: &ActuationWorkspace, q: &[f64], v: &[f64], tau: &mut [f64]) {
        for Tendon { length, law } in &self.tendons {
            let force = law.spring_force(length.at(q)) + law.dissipative_force(length.rate(v));
            length.spread(force, tau);
        }
        if let (Some(spatial), Some(memory)) = (&self.spatial, &workspace.transmissions.spatial) {
            spatial.add_passive(memory, v, tau);
        }
        self.springs.iter().for_each(|spring| spring.spread(q, v, tau));
    }

    /// Adds the carried weight computed by [`carry`](Self::carry), if it does not come from the actuators.
    fn add_weight(&self, workspace: &ActuationWorkspace, tau: &mut [f64]) {
        for (k, weight) in workspace.weight.iter().enumerate() {
            if !self.by_actuators.contains(&k) {
                tau[k] += weight;
            }
        }
    }

    #[track_caller]
    pub(super) fn check(&self, model: &Model, q: &[f64], v: &[f64], tau: &[f64]) {
        model.check_identity(&self.robot, "the actuation");
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        check_length("tau", tau.len(), model.nv);
    }

    /// Computes each actuator's f into `workspace.forces`. As in MuJoCo, the bound on the sum of f over a
    /// tendon's actuators scales them first; then each is limited to its own range.
    pub(crate) fn evaluate(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        q: &[f64],
        v: &[f64],
    ) {
        self.place_tendons(workspace, q);
        workspace.on_tendons.fill(0.0);
        for (k, (actuator, drive)) in self.actuators.iter().enumerate() {
            let (length, rate) =
                drive.length_and_rate(model, &self.tendons, &mut workspace.transmissions, (q, v));
            let u = match actuator.activation {
                Activation::None => within(u[k], actuator.control_range),
                _ => u[k],
            };
            let u = nearest_setpoint(actuator, drive, u, length);
            workspace.forces[k] = actuator.unbounded_force(u, length, rate);
            workspace.cogging[k] = actuator.cogging.map_or(0.0, |cogging| cogging.torque(length));
            let leader = self.leaders[k].unwrap_or(k);
            if self.has_controllers {
                let input = ControllerInputs { velocity: rate, error: u - length, ..Default::default() };
                workspace.controllers.inputs[k] = input;
            }
            if actuator.at_terminals && self.actuators[leader].0.motor.is_some() {
                let voltage = core::mem::take(&mut workspace.forces[k]);
                workspace.controllers.inputs[leader].terminals += voltage;
            } else if leader != k {
                workspace.forces[leader] += core::mem::take(&mut workspace.forces[k]);
            }
        }
        self.apply_controllers(workspace, self.states_of(u));
        for (k, (_, drive)) in self.actuators.iter().enumerate() {
            if let Some(tendon) = self.driven_tendon(drive) {
                workspace.on_tendons[tendon] += workspace.forces[k];
            }
        }
        for (k, (actuator, drive)) in self.actuators.iter().enumerate() {
            if let Some(tendon) = self.driven_tendon(drive) {
                workspace.forces[k] *= self.law(tendon).scale_of(workspace.on_tendons[tendon]);
            }
            workspace.forces[k] = within(workspace.forces[k], actuator.force_range) + workspace.cogging[k];
        }
    }

    /// Whether actuators pull at contacts.
    pub(crate) fn has_adhesion(&self) -> bool {
        self.actuators.iter().any(|(_, drive)| matches!(drive, Drive::Contacts { .. }))
    }

    /// The links whose contacts actuators pull together, each with the force of the last evaluation \[N\].
    pub(crate) fn adhesions<'a>(
        &'a self,
        workspace: &'a ActuationWorkspace,
    ) -> impl Iterator<Item = (FrameId, f64)> + 'a {
        self.actuators.iter().zip(&workspace.forces).filter_map(|((_, drive), &force)| match drive {
            Drive::Contacts { link } => Some((*link, force)),
            _ => None,
        })
    }

    /// The number of the tendon that a transmission acts on, those over joints first.
    pub(super) fn driven_tendon(&self, drive: &Drive) -> Option<usize> {
        match drive {
            Drive::Tendon { index, .. } => Some(*index),
            Drive::SpatialTendon { index, .. } => Some(self.tendons.len() + index),
            _ => None,
        }
    }

    /// The law of a tendon by its number.
    pub(super) fn law(&self, tendon: usize) -> &TendonLaw {
        match &self.spatial {
            Some(spatial) if tendon >= self.tendons.len() => spatial.law(tendon - self.tendons.len()),
            _ => &self.tendons[tendon].law,
        }
    }

    /// Computes the lengths and rows of spatial tendons at q into the workspace.
    pub(super) fn place_tendons(&self, workspace: &mut ActuationWorkspace, q: &[f64]) {
        if let (Some(spatial), Some(memory)) = (&self.spatial, &mut workspace.transmissions.spatial) {
            spatial.place(memory, q);
        }
    }

    /// Computes τ of the carried weight into `workspace.weight`.
    pub(super) fn carry(&self, workspace: &mut ActuationWorkspace, q: &[f64]) {
        if let (Some(weight), Some(carried)) = (&self.weight, &mut workspace.carried) {
            gravity(&weight.model, carried, q, &mut workspace.weight);
        }
    }
}

/// The setpoint that is nearest to a length among those of the same rotation, as in MuJoCo; u if it is no
/// setpoint.
fn nearest_setpoint(actuator: &ActuatorDescription, drive: &Drive, u: f64, length: f64) -> f64 {
    let period = drive.period().filter(|_| has_setpoint(actuator));
    period.map_or(u, |period| u - period * ((u - length) / period).round())
}

/// Whether u is a setpoint of ℓ: f = k (u − ℓ) and terms without u.
fn has_setpoint(actuator: &ActuatorDescription) -> bool {
    let ActuatorDescription { gain, bias, muscle, motor, activation, .. } = actuator;
    let is_position = match activation {
        Activation::None | Activation::Integrator | Activation::RateLimit { .. } => true,
        Activation::Filter { .. } | Activation::Muscle { .. } => false,
    };
    is_position && muscle.is_none() && motor.is_none() && *gain == Affine::constant(-bias.length)
}

/// The nearest number in a range.
pub(super) fn within(x: f64, [lower, upper]: [f64; 2]) -> f64 {
    x.max(lower).min(upper)
}
