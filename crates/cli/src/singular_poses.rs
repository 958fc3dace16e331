//! Where a robot's mass matrix is singular, as far as a look at a few poses tells.

use dynamics::SplitMix64;
use multibody::{Model, MotionError, SingularMass, SingularMotion, neutral, random_within_limits};
use serde::Serialize;

use crate::size::MOST;

/// Random poses looked at, always the same.
const POSES: usize = 5;

/// What was found at all zeros and in a few random poses within the limits.
pub(crate) struct SingularPoses<'a> {
    model: &'a Model,
    at_zeros: Option<SingularMass>,
    /// Random poses looked at.
    poses: usize,
    /// In how many of them, and in the first.
    random: usize,
    first: Option<SingularMass>,
}

impl<'a> SingularPoses<'a> {
    pub(crate) fn look(model: &'a Model) -> Self {
        // Robots that no other command computes are shown without this look, which would take a minute.
        let poses = if model.nv() > MOST { 0 } else { POSES };
        let singular = |q: Vec<f64>| match model.check_rank(&q) {
            Err(MotionError::SingularMass(mass)) => Some(mass),
            _ => None,
        };
        let at_zeros = if poses > 0 { singular(neutral(model)) } else { None };
        let seeded = &mut SplitMix64::new(1);
        let mut random: Vec<SingularMass> =
            (0..poses).filter_map(|_| singular(random_within_limits(model, seeded))).collect();
        Self {
            model,
            at_zeros,
            poses,
            random: random.len(),
            first: if random.is_empty() { None } else { Some(random.swap_remove(0)) },
        }
    }

    /// Where, why, and what to do, in one line; none of a robot whose M was regular everywhere.
    pub(crate) fn text(&self) -> Option<String> {
        let mass = self.at_zeros.as_ref().or(self.first.as_ref())?;
        let place = match (&self.at_zeros, self.random) {
            (Some(_), POSES) => "in every pose looked at".to_owned(),
            (Some(_), 0) => "at all zeros".to_owned(),
            (Some(_), random) => format!("at all zeros and in {random} of {POSES} random poses"),
            (None, random) => format!("in {random} of {POSES} random poses"),
        };
        Some(format!("{place} {}", advice(mass, self.model)))
    }

    pub(crate) fn json(&self) -> Json<'a> {
        let motions = |mass: &Option<SingularMass>| {
            let motions = mass.iter().flat_map(|mass| &mass.motions);
            motions.map(|SingularMotion { joints, .. }| joints.clone()).collect()
        };
        Json {
            massless_joints: self.model.massless_joints().collect(),
            motions_at_zeros: motions(&self.at_zeros),
            random_poses: self.poses,
            random_poses_singular: self.random,
            motions_in_first: motions(&self.first),
        }
    }
}

/// The same for other programs.
#[derive(Serialize)]
pub(crate) struct Json<'a> {
    /// Joints that move no inertia in any pose.
    massless_joints: Vec<&'a str>,
    /// The joints of each motion that moves no inertia at all zeros.
    motions_at_zeros: Vec<Vec<String>>,
    random_poses: usize,
    random_poses_singular: usize,
    /// The same in the first random pose that has such motions.
    motions_in_first: Vec<Vec<String>>,
}

/// A singular M, with the options that hold joints still.
pub(crate) fn advice(mass: &SingularMass, model: &Model) -> String {
    let massless = if model.massless_joints().next().is_some() { ", or --lock-massless" } else { "" };
    format!("{mass} (--lock JOINT{massless})")
}
