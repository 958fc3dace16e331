//! Maps between the coordinates of a robot and of the same robot with some joints locked.

use robot_dynamics_description::{ModelError, Pose, check_length, moved_by, unknown_name};
use robot_dynamics_number::InvalidInput;

use crate::configuration::manifold::check_configuration;
use crate::model::identity::Identity;
use crate::{Joint, Model};

/// The largest deviation of a locked joint from the reference \[m, and entries of R\].
const SAME_PLACE: f64 = 1e-9;

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
    /// - [`ModelError::Input`] for an invalid reference, or for a moving joint of the reduced model that is
    ///   absent from the full one.
    /// - [`ModelError::NotReduced`] for a joint that moves differently in the full model, or is locked more
    ///   than 1e-9 off the reference.
    pub fn new(full: &Model, reduced: &Model, reference: &[f64]) -> Result<Self, ModelError> {
        check_configuration(full, reference).map_err(|error| {
            let quantity = format!("the reference: {}", error.quantity);
            error.of(quantity)
        })?;
        let (mut q_indices, mut v_indices) = (Vec::new(), Vec::new());
        for joint in reduced.joints().iter().filter(|joint| joint.nq > 0 || joint.mimic.is_some()) {
            let own = full.joint(&joint.name).ok_or_else(|| no_such_joint(full, reduced, joint))?;
            if (own.nq, own.kind.name(), leader(own)) != (joint.nq, joint.kind.name(), leader(joint)) {
                return Err(moves_differently(joint, own));
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
                return Err(moves_differently(own, joint));
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
                return Err(locked_elsewhere(&joint.name, distance));
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
    leader(joint).map_or_else(|| joint.kind.name().into(), |leader| format!("a mimic joint of `{leader}`"))
}

fn no_such_joint(full: &Model, reduced: &Model, joint: &Joint) -> InvalidInput {
    let names = full.joints().iter().map(|joint| joint.name.as_str());
    let owner = format!(
        "joint `{}` moves in the reduced robot `{}`, but `{}`",
        joint.name,
        reduced.name(),
        full.name()
    );
    unknown_name("joint", &joint.name, owner, names)
}

fn moves_differently(reduced: &Joint, full: &Joint) -> ModelError {
    let reason = format!(
        "is {} in the reduced robot and {} in the full one; it must move the same way in both, or be fixed in the \
         reduced one",
        movement(reduced),
        movement(full)
    );
    ModelError::NotReduced { joint: full.name.clone(), reason }
}

fn locked_elsewhere(joint: &str, distance: f64) -> ModelError {
    let reason = format!(
        "is locked {distance:e} off (m, or entries of its rotation) where the reference has it; give the position \
         that it was locked at"
    );
    ModelError::NotReduced { joint: joint.into(), reason }
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
