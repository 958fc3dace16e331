//! Changes of a description before it is compiled: lock joints, attach loads, scale gravity.

use robot_dynamics_number::{InputProblem, InvalidInput, check_finite, check_number, check_result};

use crate::joint::JointDescription;
use crate::joint_kind::JointKind;
use crate::robot::LinkDescription;
use crate::{Equality, MassProperties, ModelError, Pose, Quaternion, RobotDescription};

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

    /// Attaches a load rigidly to a link. `load` is in the link's frame.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // 1 kg more at the tip: (m + 1) g l.
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("rod", &robot_dynamics::description::MassProperties::point(1.0, [0.5, 0.0, 0.0].into())?)?;
    /// let hold = Model::new(robot)?.gravity_forces(&[0.0])?;
    /// assert!((hold[0] + 3.0 * 9.81 * 0.5).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if there is no such link.
    pub fn attach_payload(&mut self, link: &str, load: &MassProperties) -> Result<(), ModelError> {
        let Some(index) = self.links.iter().position(|candidate| candidate.name == link) else {
            let names = self.links.iter().map(|link| link.name.as_str());
            return Err(InvalidInput::unknown_name("link", link, "the robot", names).into());
        };
        let LinkDescription { mass_properties, .. } = &mut self.links[index];
        *mass_properties = Some(mass_properties.map_or(*load, |own| own.combine(load)));
        Ok(())
    }

    /// Multiplies gravity: 0 for free flight, 0.38 for Mars.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.scale_gravity(0.0)?; // free flight
    /// assert_eq!(Model::new(robot)?.gravity_forces(&[0.3])?[0], 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if the factor or the scaled gravity is not finite.
    pub fn scale_gravity(&mut self, factor: f64) -> Result<(), ModelError> {
        let scaled = self.gravity.map(|g| g * factor);
        check_number("the factor of gravity", factor)?;
        check_result("the scaled gravity", &scaled)?;
        self.gravity = scaled;
        Ok(())
    }

    fn joint_index(&self, name: &str) -> Result<usize, ModelError> {
        let index = self.joints.iter().position(|joint| joint.name == name);
        Ok(index.ok_or_else(|| self.no_joint(name))?)
    }

    /// The error for a missing joint.
    pub(crate) fn no_joint(&self, name: &str) -> InvalidInput {
        let names = self.joints.iter().map(|joint| joint.name.as_str());
        InvalidInput::unknown_name("joint", name, "the robot", names)
    }
}

/// Changes a joint to a fixed one, with its child at `joint_from_child`.
fn fix(joint: &mut JointDescription, joint_from_child: &Pose) {
    joint.parent_from_joint = joint.parent_from_joint.compose(joint_from_child);
    joint.kind = JointKind::Fixed;
    joint.limits = crate::Limits::default();
    joint.passive = crate::PassiveForces::default();
}

/// The placement of the child in the joint's frame at position q. `None` if an axis or a quaternion is zero.
#[doc(hidden)]
pub fn moved_by(kind: &JointKind, q: &[f64]) -> Option<Pose> {
    let along = |axis: [f64; 3], distance: f64| {
        Some(Pose::from_translation(unit(axis)?.map(|component| component * distance)))
    };
    match *kind {
        JointKind::Fixed => Some(Pose::IDENTITY),
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => about(axis, q[0]),
        JointKind::Prismatic { axis } => along(axis, q[0]),
        JointKind::Helical { axis, pitch } => Some(along(axis, pitch * q[0])?.compose(&about(axis, q[0])?)),
        JointKind::Universal { first, second } => Some(about(first, q[0])?.compose(&about(second, q[1])?)),
        JointKind::Planar { normal } => {
            let triad = crate::joint_kind::z_onto(normal);
            let shift = Pose::from_translation(triad.rotate([q[0], q[1], 0.0]));
            Some(shift.compose(&about(normal, q[2])?))
        }
        JointKind::Spherical => turned([0.0; 3], q),
        JointKind::Floating => turned([q[0], q[1], q[2]], &q[3..]),
    }
}

fn turned(translation: [f64; 3], xyzw: &[f64]) -> Option<Pose> {
    let xyzw = [xyzw[0], xyzw[1], xyzw[2], xyzw[3]];
    let norm = xyzw.iter().map(|c| c * c).sum::<f64>();
    (norm > 0.0 && norm.is_finite()).then(|| Pose::from_translation_quaternion_xyzw(translation, xyzw))
}

fn about(axis: [f64; 3], angle: f64) -> Option<Pose> {
    let turn = Quaternion::exp(unit(axis)?.map(|component| component * angle));
    // The square of an angle beyond 1e154 overflows; the quaternion is then not finite, and the result
    // `None`.
    turned([0.0; 3], &turn.to_xyzw())
}

fn unit(axis: [f64; 3]) -> Option<[f64; 3]> {
    let norm = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| axis.map(|component| component / norm))
}
