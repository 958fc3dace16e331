//! Maps between the coordinates of a robot and of the same robot with some joints locked.

use robot_dynamics_description::{Pose, check_length, moved_by, similar};
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::configuration::manifold::check_configuration;
use crate::model::identity::Identity;
use crate::{Joint, Model};

/// The largest deviation of a locked joint from the reference \[m, and entries of R\].
const SAME_PLACE: f64 = 1e-9;

/// A reduced model that does not match the full one.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum JointMapError {
    /// The reference is an invalid configuration of the full model.
    #[error("the reference: {0}")]
    Reference(#[from] InvalidInput),
    /// The full model lacks a moving joint of the reduced model.
    #[error(
        "joint `{joint}` of the reduced robot `{reduced}` is none of `{full}`{}",
        .similar.as_ref().map(|similar| format!("; is it `{similar}`?")).unwrap_or_default()
    )]
    NoSuchJoint {
        /// The joint.
        joint: String,
        /// The reduced robot's name.
        reduced: String,
        /// The full robot's name.
        full: String,
        /// The full robot's joint of the most similar name, if there is one.
        similar: Option<String>,
    },
    /// The joint has different kinds in the two models, or is a mimic joint in only one of them.
    #[error(
        "joint `{joint}` is {reduced} in the reduced robot and {full} in the full one; \
         it must move the same way in both, or be fixed in the reduced one"
    )]
    DifferentJoint {
        /// The joint.
        joint: String,
        /// Its motion in the reduced robot: its kind, or its leader.
        reduced: String,
        /// Its motion in the full robot.
        full: String,
    },
    /// The joint is locked at a position that differs from the reference.
    #[error(
        "joint `{joint}` is locked {distance:e} off (m, or entries of its rotation) where the reference has it; \
         give the position that it was locked at"
    )]
    LockedElsewhere {
        /// The joint, or the base's joint if the base is fixed.
        joint: String,
        /// The largest difference of an entry of its child's placement.
        distance: f64,
    },
}

impl Classified for JointMapError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Reference(error) => error.kind(),
            Self::NoSuchJoint { .. } => ErrorKind::UnknownName,
            Self::DifferentJoint { .. } | Self::LockedElsewhere { .. } => ErrorKind::Description,
        }
    }
}

/// The indices in a full model's q and v of the numbers of a reduced one.
///
/// The reduced model is the same robot with some joints locked
/// ([`lock_joint`](robot_dynamics_description::RobotDescription::lock_joint),
/// [`lock_massless`](crate::lock_massless), a floating base fixed) or removed. Joints correspond by name.
///
/// Let E be the nv × nv′ matrix of zeros and ones with v = E v′. The reduced robot's equation is the full
/// one's with the locked joints at rest: M′ = EᵀM E, τ′ = Eᵀτ. The forces that hold the locked joints are in
/// the rows of τ that `restrict` leaves out.
///
/// ```
/// use robot_dynamics::model::{JointMap, Model};
/// # use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose};
/// # use robot_dynamics::description::RobotDescription;
/// # let rod = robot_dynamics::description::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
/// # let mut robot = RobotDescription::new("arm");
/// # for (name, mass_properties) in [("base", None), ("upper", rod), ("fore", rod), ("tip", rod)] {
/// #     robot.links.push(LinkDescription::new(name, mass_properties));
/// # }
/// # let kind = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
/// # let ahead = Pose::from_translation([1.0, 0.0, 0.0]);
/// # robot.joints.push(JointDescription::new("shoulder", kind, "base", "upper", ahead));
/// # robot.joints.push(JointDescription::new("elbow", kind, "upper", "fore", ahead));
/// # robot.joints.push(JointDescription::new("wrist", kind, "fore", "tip", ahead));
/// let full = Model::new(robot.clone())?; // shoulder, elbow, wrist
/// robot.lock_joint("elbow", &[0.3])?;
/// let reduced = Model::new(robot)?; // shoulder, wrist
/// let map = JointMap::new(&full, &reduced, &[0.0, 0.3, 0.0])?;
/// let (mut q, mut v) = ([0.0; 3], [0.0; 3]);
/// map.expand_configuration(&[0.1, 0.2], &mut q);
/// map.expand_velocity(&[1.0, 2.0], &mut v);
/// assert_eq!((q, v), ([0.1, 0.3, 0.2], [1.0, 0.0, 2.0]));
/// assert_eq!((map.v_indices(), map.locked_joints()), (&[0, 2][..], &["elbow".to_string()][..]));
/// let mut tau = [0.0; 2];
/// map.restrict_velocity(full.gravity_forces(&q)?.as_slice(), &mut tau);
/// assert!((reduced.gravity_forces(&[0.1, 0.2])?[0] - tau[0]).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointMap {
    full: Identity,
    reduced: Identity,
    reference: Vec<f64>,
    nv: usize,
    q_indices: Vec<usize>,
    v_indices: Vec<usize>,
    locked: Vec<String>,
}

impl JointMap {
    /// Finds the reduced model's joints in the full one. `reference` is a configuration of the full model, nq
    /// numbers. Only the positions of joints that are locked in the reduced model are used.
    ///
    /// Masses and gravity are not compared: a load attached to only one of the two is not an error.
    ///
    /// # Errors
    /// [`JointMapError`]: an invalid reference; a moving joint of the reduced model that is absent from the
    /// full one or moves differently there; or a joint locked more than 1e-9 off the reference.
    pub fn new(full: &Model, reduced: &Model, reference: &[f64]) -> Result<Self, JointMapError> {
        check_configuration(full, reference)?;
        let (mut q_indices, mut v_indices) = (Vec::new(), Vec::new());
        for joint in reduced.joints().iter().filter(|joint| joint.nq > 0 || joint.mimic.is_some()) {
            let own = full.joint(&joint.name).ok_or_else(|| JointMapError::NoSuchJoint {
                joint: joint.name.clone(),
                reduced: reduced.name().to_owned(),
                full: full.name().to_owned(),
                similar: similar(&joint.name, full.joints().iter().map(|joint| joint.name.as_str())),
            })?;
            if (own.nq, own.kind.name(), leader(own)) != (joint.nq, joint.kind.name(), leader(joint)) {
                let (joint, reduced, full) = (joint.name.clone(), movement(joint), movement(own));
                return Err(JointMapError::DifferentJoint { joint, reduced, full });
            }
            q_indices.extend(own.q());
            v_indices.extend(own.v());
        }
        // A mimic joint that is locked while its leader moves.
        for joint in full.joints() {
            let moves = |name| reduced.joint(name).is_some_and(|own| own.nq > 0 || own.mimic.is_some());
            if let (Some(leader), Some(own)) = (leader(joint), reduced.joint(&joint.name))
                && moves(leader)
                && own.mimic.is_none()
            {
                let (reduced, full) = (movement(own), movement(joint));
                return Err(JointMapError::DifferentJoint { joint: joint.name.clone(), reduced, full });
            }
        }
        let mut locked = Vec::new();
        for joint in full.joints().iter().filter(|joint| joint.nq > 0) {
            if reduced.joint(&joint.name).is_some_and(|other| other.nq > 0) {
                continue;
            }
            let q = &reference[joint.q()];
            let distance = distance_from_reference(full, reduced, joint, q);
            if distance.is_nan() || distance > SAME_PLACE {
                return Err(JointMapError::LockedElsewhere { joint: joint.name.clone(), distance });
            }
            locked.push(joint.name.clone());
        }
        let (reference, nv) = (reference.to_vec(), full.nv());
        let (full, reduced) = (full.identity.clone(), reduced.identity.clone());
        Ok(Self { full, reduced, reference, nv, q_indices, v_indices, locked })
    }

    /// The index in the full model's q of each number of the reduced one's.
    pub fn q_indices(&self) -> &[usize] {
        &self.q_indices
    }

    /// The index in the full model's v of each number of the reduced one's.
    pub fn v_indices(&self) -> &[usize] {
        &self.v_indices
    }

    /// The joints that move only in the full model, in the order of its q.
    pub fn locked_joints(&self) -> &[String] {
        &self.locked
    }

    /// Panics unless the models are those of this map.
    ///
    /// # Panics
    /// If one of the two is another robot. The message has both names.
    #[track_caller]
    pub fn check(&self, full: &Model, reduced: &Model) {
        full.check_identity(&self.full, "the joint map's full side");
        reduced.check_identity(&self.reduced, "the joint map's reduced side");
    }

    /// The full model's q for the reduced one's, with locked joints at the reference. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn expand_configuration(&self, reduced_q: &[f64], full_q: &mut [f64]) {
        check_length("the full q", full_q.len(), self.reference.len());
        full_q.copy_from_slice(&self.reference);
        scatter("the reduced q", &self.q_indices, reduced_q, full_q);
    }

    /// The full model's v (or a) for the reduced one's, with 0 for locked joints. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn expand_velocity(&self, reduced_v: &[f64], full_v: &mut [f64]) {
        check_length("the full v", full_v.len(), self.nv);
        full_v.fill(0.0);
        scatter("the reduced v", &self.v_indices, reduced_v, full_v);
    }

    /// The reduced model's part of a full q. If locked joints deviate from the reference, the bodies of the
    /// two robots are in different places. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn restrict_configuration(&self, full_q: &[f64], reduced_q: &mut [f64]) {
        check_length("the full q", full_q.len(), self.reference.len());
        gather("the reduced q", &self.q_indices, full_q, reduced_q);
    }

    /// The reduced model's part of a full v, a or τ. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn restrict_velocity(&self, full_v: &[f64], reduced_v: &mut [f64]) {
        check_length("the full v", full_v.len(), self.nv);
        gather("the reduced v", &self.v_indices, full_v, reduced_v);
    }
}

#[track_caller]
fn scatter(name: &str, indices: &[usize], from: &[f64], to: &mut [f64]) {
    check_length(name, from.len(), indices.len());
    indices.iter().zip(from).for_each(|(&i, x)| to[i] = *x);
}

#[track_caller]
fn gather(name: &str, indices: &[usize], from: &[f64], to: &mut [f64]) {
    check_length(name, to.len(), indices.len());
    indices.iter().zip(to).for_each(|(&i, x)| *x = from[i]);
}

fn leader(joint: &Joint) -> Option<&str> {
    joint.mimic.as_ref().map(|mimic| mimic.joint.as_str())
}

/// A joint's kind, or its leader.
fn movement(joint: &Joint) -> String {
    leader(joint).map_or_else(|| joint.kind.name().into(), |leader| format!("a follower of `{leader}`"))
}

/// The largest difference between entries of a joint's placement in the reduced model and at q; 0 if the
/// joint is removed.
fn distance_from_reference(full: &Model, reduced: &Model, joint: &Joint, q: &[f64]) -> f64 {
    let describes = |model: &Model| {
        model.description().joints.iter().find(|own| own.name == joint.name).map(|own| own.parent_from_joint)
    };
    let (unlocked, found) = match (describes(full), describes(reduced)) {
        (Some(unlocked), Some(found)) => (unlocked, found),
        // The description has no joint for a floating base; a fixed base is at the world's origin.
        (None, _) => (Pose::IDENTITY, Pose::IDENTITY),
        (Some(_), None) => return 0.0,
    };
    let Some(moved) = moved_by(&joint.kind, q) else { return f64::NAN };
    let expected = unlocked.compose(&moved);
    let numbers =
        |pose: &Pose| [pose.translation].into_iter().chain(pose.rotation).flatten().collect::<Vec<_>>();
    let off = numbers(&expected).into_iter().zip(numbers(&found)).map(|(a, b)| (a - b).abs());
    off.fold(0.0, |most: f64, x| if x.is_nan() { x } else { most.max(x) })
}
