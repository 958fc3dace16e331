//! MuJoCo's default step with MuJoCo's soft constraints, for comparison.
//!
//! v̇ is that of [`SoftConstraints`], in coordinates where a free body's linear velocity has the world's
//! axes. With the joints' damping D the step is v⁺ = v + h(M + hD)⁻¹M v̇, and q⁺ follows from v⁺. **(MuJoCo,
//! "Computation", Numerical integration)**

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::conventions::{acceleration_to_mujoco, velocity_from_mujoco, velocity_to_mujoco};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, dissipation_derivative, integrate};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{EnergyAccount, IntegratorError, check_computed};

use crate::contact::Interrupt;
use crate::motion::integrate::check_step;
use crate::motion::simulate::{Losses, StepError, Stepper, add_passive_gains};
use crate::motion::step_actuation::{StepActuation, record, stored_energy};
use crate::{
    ActiveSet, Actuation, SoftConstraints, SoftDynamicsInputs, StateTransition, StepForces, StepWorkspace,
};

clone_in_place! {
    /// A [`Stepper`] for MuJoCo's semi-implicit Euler step: order 1, soft constraints ([`SoftConstraints`]).
    ///
    /// ```
    /// use robot_dynamics::contact::Ground;
    /// use robot_dynamics::description::{Base, LinkDescription, LinkShape, Pose, RobotDescription};
    /// use robot_dynamics::description::{Shape, ShapeRole};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, RunOptions, SimulationBuilder};
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).method(Method::Mujoco).ground(Ground::level(0.0)).build()?;
    /// let q = [0.0, 0.0, 0.06, 0.0, 0.0, 0.0, 1.0];
    /// let run = simulation.run_from(&q, &[0.0; 6], 2.0, RunOptions::new())?;
    /// assert!(run.q[2] < 0.05 && run.q[2] > 0.0495); // at rest slightly below the surface
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug)]
    pub struct MujocoEuler {
        law: SoftConstraints,
        interrupt: Interrupt,
        drive: Option<StepActuation>,
        damping: Vec<f64>,
        losses: Losses,
        /// The losses of the last step.
        last: Losses,
        links: Vec<[f64; 3]>,
        tau: Vec<f64>,
        driven: Vec<f64>,
        acceleration: Vec<f64>,
        /// The change of v, then the displacement of q.
        change: Vec<f64>,
        /// The velocity in MuJoCo's coordinates.
        qvel: Vec<f64>,
        before: Vec<f64>,
        q: Vec<f64>,
    }
}

impl MujocoEuler {
    /// Creates a stepper with these constraints, whose time step should be that of the run.
    ///
    /// # Panics
    /// Panics if the constraints belong to another model.
    #[track_caller]
    pub fn new(model: &Model, law: SoftConstraints) -> Self {
        law.check(model);
        let zeros = || vec![0.0; model.nv];
        let mut damping = zeros();
        dissipation_derivative(model, &mut damping);
        Self {
            links: vec![[0.0; 3]; law.link_count()],
            law,
            interrupt: Interrupt::default(),
            drive: None,
            damping,
            losses: Losses::default(),
            last: Losses::default(),
            tau: zeros(),
            driven: zeros(),
            acceleration: zeros(),
            change: zeros(),
            qvel: zeros(),
            before: vec![0.0; model.nv],
            q: vec![0.0; model.nq],
        }
    }

    /// Adds tendons, gravity compensation and actuators at these controls. They are explicit as in MuJoCo's
    /// step, except for the tendons' dry friction, which is a soft constraint.
    ///
    /// # Panics
    /// Panics if the number of controls differs from the number of actuators.
    #[track_caller]
    pub(crate) fn with_actuation(mut self, actuation: &Actuation, controls: &[f64]) -> Self {
        let actuation = actuation.clone().without_tendon_friction();
        self.drive = Some(StepActuation::new(self.tau.len(), &actuation, controls));
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

    /// Sets an interrupt flag. Soon after it is set, a step returns [`IntegratorError::Interrupted`] with q
    /// and v unchanged; see [`SimulationBuilder::interrupt`](crate::simulator::SimulationBuilder::interrupt).
    pub(crate) fn with_interrupt(mut self, flag: Arc<AtomicBool>) -> Self {
        self.interrupt = Interrupt::new(flag);
        self.law.watch(&self.interrupt);
        self
    }

    /// The constraints, with the forces and contacts of the last step.
    pub fn law(&self) -> &SoftConstraints {
        &self.law
    }
}

impl Stepper for MujocoEuler {
    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        check_step(h)?;
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        let dynamics = &mut workspace.dynamics;
        self.tau.copy_from_slice(forces.tau);
        if let Some(drive) = &mut self.drive {
            drive.forces(model, q, v, &mut self.driven);
            drive.record_forces();
            self.law.set_adhesion(drive.adhesions());
            self.tau.iter_mut().zip(&self.driven).for_each(|(tau, driven)| *tau += driven);
        }
        self.before.copy_from_slice(v);
        self.law.dissipates(forces.dissipation);
        let solved = self.law.forward(
            model,
            dynamics,
            SoftDynamicsInputs { q, v, tau: &self.tau, contacts: &[] },
            &mut self.acceleration,
        );
        if self.interrupt.is_set() {
            // The acceleration of an interrupted iteration is not a valid start for the next one.
            self.law.cool();
            return Err(IntegratorError::Interrupted.into());
        }
        solved?;
        if let Some(drive) = &mut self.drive {
            drive.record_adhesion(self.law.adhesion_forces());
        }
        let n = v.len();
        if forces.dissipation && self.damping.iter().any(|damping| *damping != 0.0) {
            self.law.damp((h, &self.damping), &mut self.acceleration)?;
        }
        // v⁺ along the world's axes, and q⁺ from it.
        velocity_to_mujoco(model, q, v, &mut self.qvel);
        acceleration_to_mujoco(model, q, v, &self.acceleration, &mut self.change);
        for (qvel, qacc) in self.qvel.iter_mut().zip(&self.change) {
            *qvel += h * qacc;
        }
        check_computed("v after the step", &self.qvel)?;
        for (way, qvel) in self.change.iter_mut().zip(&self.qvel) {
            *way = h * qvel;
        }
        for stretch in coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Placement) {
            self.change[stretch.v..stretch.v + 3].fill(0.0);
        }
        integrate(model, q, &self.change, &mut self.q);
        for stretch in coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Placement) {
            for k in 0..3 {
                self.q[stretch.q + k] = q[stretch.q + k] + h * self.qvel[stretch.v + k];
            }
        }
        check_computed("q after the step", &self.q)?;
        q.copy_from_slice(&self.q);
        velocity_from_mujoco(model, q, &self.qvel, v);
        for k in 0..n {
            self.before[k] = 0.5 * (self.before[k] + v[k]);
        }
        let [friction, stops, sliding, impacts] = self.law.losses(&self.before).map(|power| h * power);
        let rate = |k: usize| self.damping[k] * self.before[k] * self.before[k];
        let damping = if forces.dissipation { h * (0..n).map(rate).sum::<f64>() } else { 0.0 };
        self.last = Losses { damping, friction, stops, sliding, impacts, corrections: 0.0 };
        self.law.add_link_forces(&mut self.links);
        self.law.warm();
        Ok(())
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        stored_energy(&mut self.drive, q)
    }

    fn losses(&self) -> Option<Losses> {
        Some(self.losses)
    }

    fn contact_forces(&self) -> &[[f64; 3]] {
        &self.links
    }

    fn active_set(&self) -> Option<ActiveSet> {
        Some(self.law.active_set().clone())
    }

    fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        self.law.fix_active_set(set);
    }

    /// Damping of joints is implicit; damping of tendons and servos is explicit.
    fn explicit_gains(&self, model: &Model, _: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        add_passive_gains(model, false, stiffness, damping);
        if let Some(drive) = &self.drive {
            drive.add_gains(model.nv, stiffness, damping);
        }
    }

    fn actuator_forces(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().forces)
    }

    fn actuator_torques(&self) -> &[f64] {
        self.drive.as_ref().map_or(&[], |drive| &drive.of_step().torques)
    }

    /// Losses are forces times the mean of the velocities at the step's ends. Losses of soft constraints
    /// include the energy that these store.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        let losses = (&mut self.last, &mut self.losses);
        record(model, workspace, energy_account, transition, &mut self.drive, losses);
    }
}
