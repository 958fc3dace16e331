//! Between the coordinates of a robot and those of the same robot with some joints locked.

use thiserror::Error;

use super::configuration::{ConfigurationError, check_configuration};
use crate::model::error::similar;
use crate::model::identity::Identity;
use crate::model::length::check_length;
use crate::model::surgery::moved_by;
use crate::{Joint, Model, Pose};

/// By how much a locked joint may stand off where the reference has it \[m, and entries of R\].
const SAME_PLACE: f64 = 1e-9;

/// Why two models are not a robot and the same robot with joints locked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum JointMapError {
    /// The reference is no configuration of the full model.
    #[error("the reference: {0}")]
    Reference(#[from] ConfigurationError),
    /// A moving joint of the reduced model that the full one has not.
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
        /// The full robot's joint that is named most like it, if one is.
        similar: Option<String>,
    },
    /// A joint that moves otherwise in the two models: of another kind, or a follower in one of them alone.
    #[error(
        "joint `{joint}` is {reduced} in the reduced robot and {full} in the full one; \
         it must move the same way in both, or be fixed in the reduced one"
    )]
    DifferentJoint {
        /// The joint.
        joint: String,
        /// How it moves in the reduced robot: its kind, or whom it follows.
        reduced: String,
        /// How it moves in the full robot.
        full: String,
    },
    /// A joint is locked elsewhere than where the reference has it.
    #[error(
        "joint `{joint}` is locked {distance:e} off (m, or entries of its rotation) where the reference has it; \
         give the position that it was locked at"
    )]
    LockedElsewhere {
        /// The joint; the name of the base's where that is fixed.
        joint: String,
        /// The largest difference of an entry of its child's placement.
        distance: f64,
    },
}

/// Which numbers of a full model's q and v are those of a reduced one: the same robot with some joints locked
/// ([`lock_joint`](crate::RobotDescription::lock_joint), [`lock_massless`](crate::RobotDescription::lock_massless), a
/// floating base fixed) or cut off. Joints are the same where their names are.
///
/// With E the nv × nv′ matrix of zeros and ones that v = E v′ stands for, the reduced robot's equation is the full one's
/// at rest in the locked joints: M′ = EᵀM E, τ′ = Eᵀτ. What holds the locked joints is in the rows of τ that
/// `restrict` leaves out.
///
/// ```
/// # use multibody::{JointDescription, JointKind, LinkDescription, Pose, RobotDescription};
/// use multibody::{JointMap, Model};
/// # let rod = dynamics::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
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
    /// Finds the reduced model's joints in the full one. `reference` is a configuration of the full model, nq numbers, of
    /// which those of joints that do not move in the reduced model count: where they stand.
    ///
    /// Masses and gravity are not compared: a load attached to one of the two is no error.
    ///
    /// # Errors
    /// [`JointMapError`]: the reference is no configuration; a moving joint of the reduced model is not in the full one,
    /// or moves otherwise there; a joint is locked elsewhere than where the reference has it (1e-9).
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
            q_indices.extend(own.q_index..own.q_index + own.nq);
            v_indices.extend(own.v_index..own.v_index + own.nv);
        }
        // A follower that stands still while its leader moves.
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
            let q = &reference[joint.q_index..joint.q_index + joint.nq];
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

    /// Where each number of the reduced model's q is in the full one's: nq of the reduced model.
    pub fn q_indices(&self) -> &[usize] {
        &self.q_indices
    }

    /// Where each number of the reduced model's v is in the full one's: nv of the reduced model.
    pub fn v_indices(&self) -> &[usize] {
        &self.v_indices
    }

    /// The joints that move in the full model alone, in the order of its q.
    pub fn locked_joints(&self) -> &[String] {
        &self.locked
    }

    /// Refuses other models than those it was made for, for whoever is handed the three.
    ///
    /// # Panics
    /// If one of the two is another robot, with both names.
    #[track_caller]
    pub fn check(&self, full: &Model, reduced: &Model) {
        self.full.check(full, "the joint map's full side");
        self.reduced.check(reduced, "the joint map's reduced side");
    }

    /// The full model's q for the reduced one's; locked joints stand where the reference has them. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn expand_configuration(&self, reduced_q: &[f64], full_q: &mut [f64]) {
        check_length("the full q", full_q.len(), self.reference.len());
        full_q.copy_from_slice(&self.reference);
        scatter("the reduced q", &self.q_indices, reduced_q, full_q);
    }

    /// The full model's v (or a) for the reduced one's, 0 of locked joints. No allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn expand_velocity(&self, reduced_v: &[f64], full_v: &mut [f64]) {
        check_length("the full v", full_v.len(), self.nv);
        full_v.fill(0.0);
        scatter("the reduced v", &self.v_indices, reduced_v, full_v);
    }

    /// The reduced model's part of a full q. Where locked joints are off the reference the reduced robot is
    /// elsewhere. No allocation.
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

/// A joint's kind, or whom it follows.
fn movement(joint: &Joint) -> String {
    leader(joint).map_or_else(|| joint.kind.name().into(), |leader| format!("a follower of `{leader}`"))
}

/// The largest entry by which a joint's child stands elsewhere in the reduced model than at q; 0 where it is cut off.
fn distance_from_reference(full: &Model, reduced: &Model, joint: &Joint, q: &[f64]) -> f64 {
    let describes = |model: &Model| {
        model.description().joints.iter().find(|own| own.name == joint.name).map(|own| own.parent_from_joint)
    };
    let (unlocked, found) = match (describes(full), describes(reduced)) {
        (Some(unlocked), Some(found)) => (unlocked, found),
        // The floating base's joint is none of the description; a fixed one stands at the world's origin.
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
