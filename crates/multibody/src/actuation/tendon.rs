//! A fixed tendon of a compiled robot.

use crate::space::joint_sum::JointSum;
use crate::{Model, TendonDescription};

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

    /// −k·stretch, what the spring gives.
    pub(super) fn spring_force(&self, q: &[f64]) -> f64 {
        -self.description.passive.stiffness * self.description.stretch(self.length.at(q))
    }

    /// −d ℓ̇ − f sign ℓ̇, what takes energy out.
    pub(super) fn dissipative_force(&self, v: &[f64]) -> f64 {
        self.dissipative_force_at(self.length.rate(v))
    }

    /// The same for ℓ̇.
    pub(super) fn dissipative_force_at(&self, rate: f64) -> f64 {
        let passive = &self.description.passive;
        let sign = if rate == 0.0 { 0.0 } else { rate.signum() };
        -passive.damping * rate - passive.friction * sign
    }

    /// ½ k·stretch² \[J\].
    pub(super) fn energy(&self, q: &[f64]) -> f64 {
        0.5 * self.description.passive.stiffness * self.description.stretch(self.length.at(q)).powi(2)
    }

    /// k and d.
    pub(super) fn gains(&self) -> (f64, f64) {
        (self.description.passive.stiffness, self.description.passive.damping)
    }

    /// The largest force of its actuators together \[N\].
    pub(super) fn most_force(&self) -> f64 {
        self.description.limits.effort
    }
}
