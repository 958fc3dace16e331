//! The description of a singular mass matrix.

use core::fmt;
use std::collections::HashSet;

use robot_dynamics_number::{Classified, ErrorKind};

use super::vanished_pivot::VanishedPivot;
use crate::Model;

/// A joint takes part in a motion if its share exceeds this fraction of the largest. Rounding of a joint that
/// takes no part is far smaller; a real share rarely is.
const PART: f64 = 1e-6;

/// The number of joints that a message lists by name.
const LISTED: usize = 8;

/// A motion that moves no inertia: the forces do not determine the acceleration along it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SingularMotion {
    /// The joints that take part, in the order of v. A single joint moves no inertia by itself.
    pub joints: Vec<String>,
    /// The coordinate whose pivot vanished, as in [`Model::coordinate_names`]; later coordinates can be
    /// chosen freely.
    pub coordinate: String,
    /// Its index in v.
    pub index: usize,
    /// The pivot: the inertia along the coordinate while the joints beyond it move freely \[kg or kg·m²\]. It
    /// is rounding of `inertia`, of either sign.
    pub pivot: f64,
    /// The sum of the terms of the inertia along the coordinate, with all joints beyond it locked \[kg or
    /// kg·m²\].
    pub inertia: f64,
}

impl SingularMotion {
    /// Whether the energy of the motion is negative beyond rounding, as for a body with a negative moment of
    /// inertia.
    fn is_negative(&self) -> bool {
        self.pivot < -1e-9 * self.inertia
    }

    pub(super) fn named(model: &Model, vanished: &VanishedPivot<'_>) -> Self {
        let VanishedPivot { index, pivot, inertia, share } = *vanished;
        let most = share.iter().fold(0.0, |most: f64, &x| most.max(x));
        let first = model.joint_at(index);
        let mut joints = vec![first.name.clone()];
        let mut named = first.v_index + first.nv;
        for coordinate in index..index + share.len() {
            if coordinate >= named && share[coordinate - index] > PART * most {
                let joint = model.joint_at(coordinate);
                joints.push(joint.name.clone());
                named = joint.v_index + joint.nv;
            }
        }
        let coordinate = first.coordinate_names().swap_remove(index - first.v_index);
        Self { joints, coordinate, index, pivot, inertia }
    }
}

/// M(q) is not positive definite: some motion moves no inertia, so the forces do not determine the
/// acceleration.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SingularMass {
    /// A basis of the motions that move no inertia, from the last coordinate to the first.
    pub motions: Vec<SingularMotion>,
}

impl SingularMass {
    /// The joints that take part in some motion without inertia, each once.
    pub fn joints(&self) -> Vec<&str> {
        let mut seen = HashSet::new();
        let all = self.motions.iter().rev().flat_map(|motion| &motion.joints);
        all.map(String::as_str).filter(|name| seen.insert(*name)).collect()
    }

    /// A single coordinate on which a factorization of M failed.
    pub fn at(model: &Model, index: usize, pivot: f64) -> Self {
        let vanished = VanishedPivot { index, pivot, inertia: f64::NAN, share: &[] };
        Self { motions: vec![SingularMotion::named(model, &vanished)] }
    }
}

impl fmt::Display for SingularMass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut seen = HashSet::new();
        let negative = self.motions.iter().rev().filter(|motion| motion.is_negative());
        let negative: Vec<String> = negative
            .map(|motion| motion.joints[0].clone())
            .filter(|name| seen.insert(name.clone()))
            .collect();
        let mut seen = HashSet::new();
        let groups = self.motions.iter().rev().filter(|motion| !motion.is_negative());
        let groups = groups.map(|motion| motion.joints.as_slice()).filter(|joints| seen.insert(*joints));
        let (alone, together): (Vec<&[String]>, Vec<&[String]>) = groups.partition(|joints| joints.len() < 2);
        let is = if negative.is_empty() { "singular" } else { "not positive definite" };
        write!(f, "the mass matrix is {is}: ")?;
        let mut parts = Vec::new();
        match negative.len() {
            0 => {}
            1 => parts.push(format!("joint {} moves a negative inertia", listed(&negative))),
            _ => parts.push(format!("joints {} move a negative inertia", listed(&negative))),
        }
        // Joints that move no inertia by themselves form one list.
        match alone.len() {
            0 => {}
            1 => parts.push(format!("joint {} moves no inertia", listed(alone[0]))),
            _ => parts.push(format!("joints {} move no inertia", listed(&alone.concat()))),
        }
        let against = |joints: &&[String]| {
            format!("joints {} can move against each other without moving any inertia", listed(joints))
        };
        parts.extend(together.iter().take(LISTED).map(against));
        if together.len() > LISTED {
            parts.push(format!("and {} more such groups", together.len() - LISTED));
        }
        f.write_str(&parts.join("; "))?;
        write!(
            f,
            "; no acceleration follows from the forces: give the links there mass or the joint armature, or lock a \
             joint"
        )
    }
}

impl core::error::Error for SingularMass {}

impl Classified for SingularMass {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Singular
    }
}

/// Formats the list as "`a`, `b` and 3 more".
fn listed(names: &[String]) -> String {
    let text = names.iter().take(LISTED).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > LISTED { format!("{text} and {} more", names.len() - LISTED) } else { text }
}
