//! Poses with a singular mass matrix, found by sampling.

use robot_dynamics::algorithms::{MotionError, SingularMass, SingularMotion};
use robot_dynamics::model::{Model, neutral, random_within_limits};
use robot_dynamics_number::SplitMix64;
use serde::Serialize;

use crate::size::MAX_DOFS;

/// Number of random poses, always the same ones.
const POSES: usize = 5;

/// Results at all zeros and at random poses within the limits.
pub(crate) struct SingularPoses<'a> {
    model: &'a Model,
    at_zeros: Option<SingularMass>,
    /// Number of random poses.
    poses: usize,
    /// The number of singular ones, and the first of them.
    random: usize,
    first: Option<SingularMass>,
}

impl<'a> SingularPoses<'a> {
    pub(crate) fn sample(model: &'a Model) -> Self {
        // For robots above the size that other commands accept, sampling would take a minute.
        let poses = if model.nv() > MAX_DOFS { 0 } else { POSES };
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

    /// The pose, the cause and the remedy in one line; `None` if M was regular in all poses.
    pub(crate) fn text(&self) -> Option<String> {
        let mass = self.at_zeros.as_ref().or(self.first.as_ref())?;
        let place = match (&self.at_zeros, self.random) {
            (Some(_), POSES) => "in every sampled pose".to_owned(),
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

/// The results as JSON.
#[derive(Serialize)]
pub(crate) struct Json<'a> {
    /// Joints that move no inertia in any pose.
    massless_joints: Vec<&'a str>,
    /// The joints of each motion without inertia at all zeros.
    motions_at_zeros: Vec<Vec<String>>,
    random_poses: usize,
    random_poses_singular: usize,
    /// The same in the first singular random pose.
    motions_in_first: Vec<Vec<String>>,
}

/// The message on a singular M, with the options that lock joints.
pub(crate) fn advice(mass: &SingularMass, model: &Model) -> String {
    let massless = if model.massless_joints().next().is_some() { ", or --lock-massless" } else { "" };
    format!("{mass} (--lock JOINT{massless})")
}
