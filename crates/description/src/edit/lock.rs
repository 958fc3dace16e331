//! Locks joints at a position.

use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};

use super::motion::moved_by;
use crate::joint::JointDescription;
use crate::joint_kind::JointKind;
use crate::{Equality, ModelError, Pose, RobotDescription};

impl RobotDescription {
    /// Locks a joint at position q (as many numbers as its kind has). It becomes a fixed joint there, and so
    /// do its mimic joints. The dynamics are those of the whole robot with that joint held. Sensors of these
    /// joints' positions, velocities and forces are removed.
    ///
    /// ```
    /// # use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose};
    /// # use robot_dynamics::description::RobotDescription;
    /// # use robot_dynamics::model::Model;
    /// # let rod = robot_dynamics::description::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
    /// # let mut robot = RobotDescription::new("arm");
    /// # for (name, mass_properties) in [("base", None), ("upper", rod), ("fore", rod)] {
    /// #     robot.links.push(LinkDescription::new(name, mass_properties));
    /// # }
    /// # let kind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    /// # let ahead = Pose::from_translation([1.0, 0.0, 0.0]);
    /// # robot.joints.push(JointDescription::new("shoulder", kind, "base", "upper", ahead));
    /// # robot.joints.push(JointDescription::new("elbow", kind, "upper", "fore", ahead));
    /// assert_eq!(Model::new(robot.clone())?.nv(), 2);
    /// robot.lock_joint("elbow", &[0.3])?;
    /// assert_eq!(Model::new(robot)?.nv(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] for an unknown joint, a mimic joint, or an invalid position.
    pub fn lock_joint(&mut self, name: &str, q: &[f64]) -> Result<(), ModelError> {
        let index = self.joint_index(name)?;
        let joint = &mut self.joints[index];
        if let Some(mimic) = &joint.mimic {
            return Err(ModelError::Follows { joint: name.into(), leader: mimic.joint.clone() });
        }
        let quantity = format!("the position of joint `{name}`");
        check_finite(&quantity, q)?;
        let (found, expected) = (q.len(), joint.kind.nq());
        if found != expected {
            let owner = format!("its kind ({})", joint.kind.name());
            let problem = InputProblem::WrongLength { found, expected, owner, hint: "" };
            return Err(InvalidInput::new(quantity, problem).into());
        }
        let Some(moved) = moved_by(&joint.kind, q) else {
            return Err(if expected > joint.kind.nv() {
                let (first, joint, norm) = (expected - 4, name.to_owned(), 0.0);
                InvalidInput::new(quantity, InputProblem::NotAUnitQuaternion { first, joint, norm }).into()
            } else {
                ModelError::ZeroAxis { joint: name.into(), axis: [0.0; 3] }
            });
        };
        fix(joint, &moved);
        self.update_couplings(name, q);
        self.lock_followers(name, q);
        Ok(())
    }

    /// The default position of a locked joint: neutral (0, no rotation), or the nearest limit if neutral is
    /// outside the limits.
    ///
    /// ```
    /// use robot_dynamics::description::{Limits, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert_eq!(robot.resting_position("hinge")?, [0.0]);
    /// robot.joints[0].limits = Limits::new(0.2, 1.0);
    /// assert_eq!(robot.resting_position("hinge")?, [0.2]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] for an unknown joint; [`ModelError::Follows`] for a mimic joint, which has no
    /// position of its own.
    pub fn resting_position(&self, name: &str) -> Result<Vec<f64>, ModelError> {
        let joint = &self.joints[self.joint_index(name)?];
        if let Some(mimic) = &joint.mimic {
            return Err(ModelError::Follows { joint: name.into(), leader: mimic.joint.clone() });
        }
        let mut q = vec![0.0_f64; joint.kind.nq()];
        if joint.kind.nq() > joint.kind.nv() {
            // The identity quaternion (0, 0, 0, 1) at the end.
            let last = q.len() - 1;
            q[last] = 1.0;
        } else {
            let crate::Limits { lower, upper, .. } = joint.limits;
            for q in &mut q {
                *q = q.max(lower).min(upper);
            }
        }
        Ok(q)
    }

    /// Locks every mimic joint of `leader` (directly or through others) at its position for `q`.
    fn lock_followers(&mut self, leader: &str, q: &[f64]) {
        let follows =
            |joint: &JointDescription| joint.mimic.as_ref().is_some_and(|mimic| mimic.joint == leader);
        while let Some(index) = self.joints.iter().position(follows) {
            let joint = &mut self.joints[index];
            let Some(mimic) = joint.mimic.take() else { continue };
            let position = [mimic.ratio * q[0] + mimic.offset];
            if let Some(moved) = moved_by(&joint.kind, &position) {
                fix(joint, &moved);
            }
            let name = joint.name.clone();
            self.update_couplings(&name, &position);
            self.lock_followers(&name, &position);
        }
    }

    /// Updates tendons and equalities for a joint locked at `q`. Lengths keep the joint's share as a
    /// constant, functions of its position become constants, and an equality that gives its position is
    /// switched off.
    fn update_couplings(&mut self, name: &str, q: &[f64]) {
        self.sensors.retain(|sensor| !sensor.is_of_joint(name));
        let &[position] = q else { return };
        for tendon in &mut self.tendons {
            for (_, factor) in tendon.terms.iter().filter(|(joint, _)| joint == name) {
                tendon.offset += factor * position;
            }
            tendon.terms.retain(|(joint, _)| joint != name);
        }
        for equality in &mut self.equalities {
            let Equality::Joints { joint, leader, polynomial } = &mut equality.kind else { continue };
            if joint.0 == name {
                equality.active = false;
            } else if let Some((_, reference)) = leader.take_if(|(leader, _)| leader == name) {
                let x = position - reference;
                *polynomial = [polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c), 0.0, 0.0, 0.0, 0.0];
            }
        }
    }
}

/// Changes a joint to a fixed one, with its child at `joint_from_child`.
fn fix(joint: &mut JointDescription, joint_from_child: &Pose) {
    joint.parent_from_joint = joint.parent_from_joint.compose(joint_from_child);
    joint.kind = JointKind::Fixed;
    joint.limits = crate::Limits::default();
    joint.passive = crate::PassiveForces::default();
}
