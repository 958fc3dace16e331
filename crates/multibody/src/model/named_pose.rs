//! Poses that a robot's file names.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A pose by name, joint by joint: MJCF's keyframes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct NamedPose {
    /// Its name.
    pub name: String,
    /// Joints by name with their stretch of q, as the joint's kind orders it; others are at neutral.
    pub positions: Vec<(String, Vec<f64>)>,
    /// Joints by name with their stretch of v; others are at rest.
    pub velocities: Vec<(String, Vec<f64>)>,
    /// The controls of all actuators, in their order; empty where the file gives none.
    pub controls: Vec<f64>,
}

impl NamedPose {
    /// A pose at rest.
    ///
    /// ```
    /// use multibody::{Model, NamedPose, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.poses.push(NamedPose::new("up", [("hinge".to_owned(), vec![3.1])]));
    /// let model = Model::new(robot)?;
    /// assert_eq!(model.named_pose("up"), Some((vec![3.1], vec![0.0])));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn new(name: impl Into<String>, positions: impl IntoIterator<Item = (String, Vec<f64>)>) -> Self {
        Self { name: name.into(), positions: positions.into_iter().collect(), ..Self::default() }
    }
}
