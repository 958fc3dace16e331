//! Changing a robot before it is compiled: lock joints, attach loads, scale gravity.

use dynamics::MassProperties;
use thiserror::Error;

use crate::joint::kind::JointKind;
use crate::model::description::LinkDescription;
use crate::model::joint_description::JointDescription;
use crate::{Base, Equality, Model, ModelError, Pose, Quaternion, RobotDescription};

/// Why a robot could not be changed as asked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SurgeryError {
    /// There is no joint or link of that name.
    #[error("the robot has no {sort} `{name}`")]
    NoSuch {
        /// `joint` or `link`.
        sort: &'static str,
        /// The name asked for.
        name: String,
    },
    /// A position with the wrong number of numbers, or with one that is not finite.
    #[error("joint `{joint}` ({kind}) is locked at {expected} finite numbers, got {found:?}")]
    BadPosition {
        /// The joint.
        joint: String,
        /// Its kind.
        kind: &'static str,
        /// How many numbers its q has.
        expected: usize,
        /// What was given.
        found: Vec<f64>,
    },
    /// The joint follows another one; lock that.
    #[error("joint `{joint}` follows joint `{leader}`; lock `{leader}` instead")]
    Follows {
        /// The follower.
        joint: String,
        /// The joint it follows.
        leader: String,
    },
    /// The description is no robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A factor that is no number.
    #[error("gravity cannot be scaled by {0}; give a finite factor")]
    BadFactor(f64),
}

impl RobotDescription {
    /// Locks a joint at position q (as many numbers as its kind has): it becomes a fixed joint there, and
    /// so do the joints that follow it. The dynamics are those of the whole robot with that joint held. Sensors of
    /// these joints' own values are taken away with their motion.
    ///
    /// ```
    /// # use multibody::{JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription};
    /// # let rod = dynamics::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
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
    /// [`SurgeryError`]: no such joint, a follower, or a position that does not fit.
    pub fn lock_joint(&mut self, name: &str, q: &[f64]) -> Result<(), SurgeryError> {
        let index = self.joint_index(name)?;
        let joint = &mut self.joints[index];
        if let Some(mimic) = &joint.mimic {
            return Err(SurgeryError::Follows { joint: name.into(), leader: mimic.joint.clone() });
        }
        let fits = q.len() == joint.kind.nq() && q.iter().all(|x| x.is_finite());
        let moved = if fits { moved_by(&joint.kind, q) } else { None };
        let Some(moved) = moved else {
            return Err(SurgeryError::BadPosition {
                joint: name.into(),
                kind: joint.kind.name(),
                expected: joint.kind.nq(),
                found: q.to_vec(),
            });
        };
        fix(joint, &moved);
        self.settle(name, q);
        self.lock_followers(name, q);
        Ok(())
    }

    /// Where a joint stands that is locked without saying where: at neutral (0, no turn), or at the limit nearest to it.
    ///
    /// ```
    /// use multibody::{Limits, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert_eq!(robot.resting_position("hinge")?, [0.0]);
    /// robot.joints[0].limits = Limits::new(0.2, 1.0);
    /// assert_eq!(robot.resting_position("hinge")?, [0.2]);
    /// # Ok::<(), multibody::SurgeryError>(())
    /// ```
    ///
    /// # Errors
    /// [`SurgeryError::NoSuch`]: no such joint; [`SurgeryError::Follows`]: it has no position of its own.
    pub fn resting_position(&self, name: &str) -> Result<Vec<f64>, SurgeryError> {
        let joint = &self.joints[self.joint_index(name)?];
        if let Some(mimic) = &joint.mimic {
            return Err(SurgeryError::Follows { joint: name.into(), leader: mimic.joint.clone() });
        }
        let mut q = vec![0.0_f64; joint.kind.nq()];
        if joint.kind.nq() > joint.kind.nv() {
            // No turn: (0, 0, 0, 1) at the end.
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

    /// Locks the joints that move no inertia in any pose ([`Model::massless_joints`]), each at its
    /// [`resting_position`](Self::resting_position), until there are none: a joint that carried only such joints may be
    /// one itself once they are still. A floating base that moves nothing is fixed. Returns their names.
    ///
    /// ```
    /// use multibody::pendulum;
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert!(robot.lock_massless()?.is_empty());
    /// robot.links[1].mass_properties = None; // now the hinge moves nothing
    /// assert_eq!(robot.lock_massless()?, ["hinge"]);
    /// # Ok::<(), multibody::SurgeryError>(())
    /// ```
    ///
    /// # Errors
    /// [`SurgeryError::Model`]: the description is no robot.
    pub fn lock_massless(&mut self) -> Result<Vec<String>, SurgeryError> {
        let mut locked = Vec::new();
        loop {
            let model = Model::new(self.clone())?;
            let massless: Vec<String> = model.massless_joints().map(Into::into).collect();
            if massless.is_empty() {
                return Ok(locked);
            }
            for name in massless {
                // The base's joint is the first of the model, and none of the description.
                if self.base == Base::Floating && name == model.joints()[0].name {
                    self.base = Base::Fixed;
                } else {
                    let q = self.resting_position(&name)?;
                    self.lock_joint(&name, &q)?;
                }
                locked.push(name);
            }
        }
    }

    /// Locks every joint that followed `leader` (directly or through others) where it is at `q`.
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
            self.settle(&name, &position);
            self.lock_followers(&name, &position);
        }
    }

    /// What tendons and equalities make of a joint that is locked at `q`: lengths keep its part, what is a function of its
    /// position becomes a number, and an equality that gives its position is switched off.
    fn settle(&mut self, name: &str, q: &[f64]) {
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

    /// Attaches a load to a link, rigidly: `load` is given in the link's frame.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// // 1 kg more at the tip: (m + 1) g l.
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("rod", &dynamics::MassProperties::point(1.0, [0.5, 0.0, 0.0].into())?)?;
    /// let hold = Model::new(robot)?.gravity_forces(&[0.0])?;
    /// assert!((hold[0] + 3.0 * 9.81 * 0.5).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SurgeryError::NoSuch`] when there is no such link.
    pub fn attach_payload(&mut self, link: &str, load: &MassProperties) -> Result<(), SurgeryError> {
        let missing = || SurgeryError::NoSuch { sort: "link", name: link.into() };
        let LinkDescription { mass_properties, .. } =
            self.links.iter_mut().find(|candidate| candidate.name == link).ok_or_else(missing)?;
        *mass_properties = Some(mass_properties.map_or(*load, |own| own.combine(load)));
        Ok(())
    }

    /// Multiplies gravity: 0 for free flight, 0.38 for Mars.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.scale_gravity(0.0)?; // free flight
    /// assert_eq!(Model::new(robot)?.gravity_forces(&[0.3])?[0], 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SurgeryError::BadFactor`] when the factor or the scaled gravity is not finite.
    pub fn scale_gravity(&mut self, factor: f64) -> Result<(), SurgeryError> {
        let scaled = self.gravity.map(|g| g * factor);
        if !factor.is_finite() || scaled.iter().any(|g| !g.is_finite()) {
            return Err(SurgeryError::BadFactor(factor));
        }
        self.gravity = scaled;
        Ok(())
    }

    fn joint_index(&self, name: &str) -> Result<usize, SurgeryError> {
        let missing = || SurgeryError::NoSuch { sort: "joint", name: name.into() };
        self.joints.iter().position(|joint| joint.name == name).ok_or_else(missing)
    }
}

/// Turns a joint into a fixed one, its child standing where `joint_from_child` says.
fn fix(joint: &mut JointDescription, joint_from_child: &Pose) {
    joint.parent_from_joint = joint.parent_from_joint.compose(joint_from_child);
    joint.kind = JointKind::Fixed;
    joint.limits = crate::Limits::default();
    joint.passive = crate::PassiveForces::default();
}

/// Where a joint at position q takes its child, from the joint's frame; `None` when an axis or a quaternion
/// has no direction.
pub(crate) fn moved_by(kind: &JointKind, q: &[f64]) -> Option<Pose> {
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
            let triad = crate::model::compile::z_onto(normal);
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
    // An angle beyond 1e154 has no square, and no quaternion.
    turned([0.0; 3], &turn.to_xyzw())
}

fn unit(axis: [f64; 3]) -> Option<[f64; 3]> {
    let norm = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| axis.map(|component| component / norm))
}
