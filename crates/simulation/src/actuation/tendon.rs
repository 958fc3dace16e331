//! A fixed tendon of a compiled robot, or a joint whose spring or damper has nonlinear terms.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_description::{JointDescription, PassiveForces, TendonDescription};

#[derive(Clone, Debug)]
pub(super) struct Tendon {
    pub(super) length: JointSum,
    description: TendonDescription,
}

impl Tendon {
    pub(super) fn new(model: &Model, description: &TendonDescription) -> Self {
        let terms = description.terms.iter().map(|(joint, factor)| (joint.as_str(), *factor));
        Self { length: JointSum::new(model, description.offset, terms), description: description.clone() }
    }

    /// Makes a tendon of a joint with its nonlinear terms alone: g and b contain the linear ones.
    pub(super) fn of_joint(model: &Model, joint: &JointDescription) -> Self {
        let mut description = TendonDescription::new(joint.name.clone(), [(joint.name.clone(), 1.0)]);
        description.passive = PassiveForces::default().with_spring(0.0, joint.passive.rest);
        description.higher_terms = joint.higher_terms;
        Self::new(model, &description)
    }

    /// Removes dry friction, which is modelled elsewhere.
    pub(super) fn forget_friction(&mut self) {
        self.description.passive.friction = 0.0;
    }

    /// Removes damping and friction.
    pub(super) fn forget_dissipation(&mut self) {
        self.description.passive.friction = 0.0;
        self.description.passive.damping = 0.0;
        self.description.higher_terms.damping = [0.0; 2];
    }

    /// Removes the spring.
    pub(super) fn forget_spring(&mut self) {
        self.description.passive.stiffness = 0.0;
        self.description.higher_terms.stiffness = [0.0; 2];
    }

    /// −k·stretch and the nonlinear terms: the spring's force.
    pub(super) fn spring_force(&self, q: &[f64]) -> f64 {
        let stretch = self.description.stretch(self.length.at(q));
        -self.description.passive.stiffness * stretch + self.description.higher_terms.spring_force(stretch)
    }

    /// −d ℓ̇ − f sign ℓ̇ and the nonlinear terms: the dissipative force.
    pub(super) fn dissipative_force(&self, v: &[f64]) -> f64 {
        self.dissipative_force_at(self.length.rate(v))
    }

    /// The dissipative force at a given ℓ̇.
    pub(super) fn dissipative_force_at(&self, rate: f64) -> f64 {
        let passive = &self.description.passive;
        let sign = if rate == 0.0 { 0.0 } else { rate.signum() };
        -passive.damping * rate - passive.friction * sign + self.description.higher_terms.damping_force(rate)
    }

    /// ½ k·stretch² and the energy of the nonlinear terms \[J\].
    pub(super) fn energy(&self, q: &[f64]) -> f64 {
        let stretch = self.description.stretch(self.length.at(q));
        0.5 * self.description.passive.stiffness * stretch.powi(2)
            + self.description.higher_terms.energy(stretch)
    }

    /// k and d.
    pub(super) fn gains(&self) -> (f64, f64) {
        (self.description.passive.stiffness, self.description.passive.damping)
    }

    /// The largest total force of its actuators \[N\].
    pub(super) fn most_force(&self) -> f64 {
        self.description.limits.effort
    }
}
