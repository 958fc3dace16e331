//! The energy that is stored outside the tree, and the power that is dissipated there.

use robot_dynamics_core::{Model, potential_energy};

use super::Actuation;
use super::tendon::Tendon;
use super::workspace::ActuationWorkspace;

impl Actuation {
    /// Returns the energy stored outside the tree \[J\]: ½ k·stretch² of tendons and springs, less the
    /// potential of the carried weight. That potential is left out if the weight comes from the actuators.
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn stored_energy(&self, workspace: &mut ActuationWorkspace, q: &[f64]) -> f64 {
        let springs = self.spring_energy(workspace, q);
        match (&self.weight, &mut workspace.carried) {
            (Some(weight), Some(carried)) if self.by_actuators.is_empty() => {
                springs - potential_energy(&weight.model, carried, q)
            }
            _ => springs,
        }
    }

    /// Lets the springs yield that are stretched too far at q, at the end of a step. Returns the energy that
    /// they lose \[J\].
    pub(crate) fn yield_springs(&mut self, workspace: &mut ActuationWorkspace, q: &[f64]) -> f64 {
        self.place_tendons(workspace, q);
        let over_joints = self.tendons.iter_mut().map(|Tendon { length, law }| law.yield_at(length.at(q)));
        let lost: f64 = over_joints.sum();
        let (Some(spatial), Some(memory)) = (&mut self.spatial, &workspace.transmissions.spatial) else {
            return lost;
        };
        lost + spatial.yield_springs(memory)
    }

    /// Returns the power that damping and friction outside the tree, and the fluid, take from the robot
    /// \[W\]. Only a fluid that moves can make it negative: wind drives the robot.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, TendonDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut cable = TendonDescription::new("cable", [("hinge".to_owned(), 2.0)]);
    /// cable.passive = PassiveForces::default().with_damping(0.3);
    /// robot.tendons.push(cable);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let power = actuation.dissipated_power(&model, &mut actuation.workspace(), &[0.0], &[5.0]);
    /// assert_eq!(power, 0.3 * (2.0_f64 * 5.0).powi(2));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn dissipated_power(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        q: &[f64],
        v: &[f64],
    ) -> f64 {
        let lost = |tendon: &Tendon| {
            let rate = tendon.length.rate(v);
            -tendon.law.dissipative_force(rate) * rate
        };
        let tendons: f64 = self.tendons.iter().map(lost).sum();
        let springs: f64 = self.springs.iter().map(|spring| spring.lost_power(q, v, v)).sum();
        let along_paths = self.power_lost_along_paths(workspace, q, v, v);
        tendons + springs + along_paths + self.power_into_fluid(model, workspace, (q, v), v)
    }

    /// −τ·`mean` of the fluid's forces at (q, v) \[W\].
    pub(crate) fn power_into_fluid(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        (q, v): (&[f64], &[f64]),
        mean: &[f64],
    ) -> f64 {
        let forces = self.fluid_forces(model, workspace, q, v);
        forces.map_or(0.0, |forces| -forces.iter().zip(mean).map(|(tau, v)| tau * v).sum::<f64>())
    }

    /// The power that dampers and friction of spatial tendons dissipate for the forces at `rate` \[W\].
    fn power_lost_along_paths(
        &self,
        workspace: &mut ActuationWorkspace,
        q: &[f64],
        rate: &[f64],
        mean: &[f64],
    ) -> f64 {
        self.place_tendons(workspace, q);
        match (&self.spatial, &workspace.transmissions.spatial) {
            (Some(spatial), Some(memory)) => spatial.lost_power(memory, rate, mean),
            _ => 0.0,
        }
    }

    /// Returns the energy that damping and friction outside the tree, without a fluid, dissipate in h \[J\].
    /// It is their impulse for a displacement of h·`rate` about q, times the mean velocity.
    pub(crate) fn dissipated_over(
        &self,
        workspace: &mut ActuationWorkspace,
        h: f64,
        q: &[f64],
        (rate, mean): (&[f64], &[f64]),
    ) -> f64 {
        let lost = |tendon: &Tendon| {
            let force = tendon.law.dissipative_force(tendon.length.rate(rate));
            (-force * tendon.length.rate(mean) * h).max(0.0)
        };
        let tendons: f64 = self.tendons.iter().map(lost).sum();
        let springs: f64 =
            self.springs.iter().map(|spring| h * spring.lost_power(q, rate, mean).max(0.0)).sum();
        tendons + springs + h * self.power_lost_along_paths(workspace, q, rate, mean)
    }
}
