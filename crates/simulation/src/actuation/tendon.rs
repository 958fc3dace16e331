//! A fixed tendon of a compiled robot, or a joint whose spring or damper has nonlinear terms.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_description::{JointDescription, PassiveForces, TendonDescription};

use super::tendon_law::TendonLaw;

#[derive(Clone, Debug)]
pub(super) struct Tendon {
    pub(super) length: JointSum,
    pub(super) law: TendonLaw,
}

impl Tendon {
    pub(super) fn new(model: &Model, description: &TendonDescription) -> Self {
        Self { length: JointSum::of_tendon(model, description), law: TendonLaw::of_joints(description) }
    }

    /// Makes a tendon of a joint with its nonlinear terms, because g and b contain the linear ones, and with
    /// its whole spring if it yields.
    pub(super) fn of_joint(model: &Model, joint: &JointDescription) -> Self {
        let mut description = TendonDescription::new(joint.name.clone(), [(joint.name.clone(), 1.0)]);
        let stiffness = if joint.spring_yield > 0.0 { joint.passive.stiffness } else { 0.0 };
        description.passive = PassiveForces::default().with_spring(stiffness, joint.passive.rest);
        description.spring_yield = joint.spring_yield;
        description.higher_terms = joint.higher_terms;
        Self::new(model, &description)
    }
}
