//! The quantities of actuators, tendons and springs that sensors measure.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;

use super::law::within;
use super::pose_spring::PoseSpring;
use super::transmission::Drive;
use super::{Actuation, ActuationWorkspace};

impl Actuation {
    /// Returns τ of actuators with known forces before their gears \[N·m or N\], nv entries. It includes the
    /// carried weight if that comes from them, and is within the bounds of the joints.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0)));
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let mut tau = [0.0];
    /// actuation.torques_of_forces(&model, &mut actuation.workspace(), &[0.3], &[0.0], &mut tau);
    /// assert_eq!(tau, [50.0 * 0.3]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn torques_of_forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        forces: &[f64],
        q: &[f64],
        tau: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the actuation");
        check_length("q", q.len(), model.nq);
        check_length("tau", tau.len(), model.nv);
        check_length("the forces", forces.len(), self.actuators.len());
        self.carry(workspace, q);
        tau.fill(0.0);
        for ((_, drive), &force) in self.actuators.iter().zip(forces) {
            drive.spread(model, &self.tendons, &mut workspace.frames, q, force, tau);
        }
        for &k in &self.by_actuators {
            tau[k] += workspace.weight[k];
        }
        for &(k, range) in &self.bounded {
            tau[k] = within(tau[k], range);
        }
    }

    /// ℓ and ℓ̇ of an actuator's transmission.
    pub(crate) fn length_and_rate(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        actuator: usize,
        state: (&[f64], &[f64]),
    ) -> (f64, f64) {
        self.actuators[actuator].1.length_and_rate(model, &self.tendons, &mut workspace.frames, state)
    }

    /// The sum of the actuators' forces on a tendon, before their gears.
    pub(crate) fn force_on_tendon(&self, tendon: usize, forces: &[f64]) -> f64 {
        let on_it = |drive: &Drive| matches!(drive, Drive::Tendon { index, .. } if *index == tendon);
        self.actuators.iter().zip(forces).filter(|((_, drive), _)| on_it(drive)).map(|(_, force)| force).sum()
    }

    /// The energy of tendons' springs, of springs of ball and floating joints, and of nonlinear terms \[J\].
    pub(crate) fn spring_energy(&self, q: &[f64]) -> f64 {
        let tendons: f64 = self.tendons.iter().map(|tendon| tendon.energy(q)).sum();
        tendons + self.springs.iter().map(|spring: &PoseSpring| spring.energy(q)).sum::<f64>()
    }
}
