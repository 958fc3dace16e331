//! Named poses of a robot's file.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A named pose, joint by joint, such as a keyframe of MJCF.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct NamedPose {
    /// Its name.
    pub name: String,
    /// Joints by name with their part of q, in the order of the joint's kind; the others are neutral.
    pub positions: Vec<(String, Vec<f64>)>,
    /// Joints by name with their part of v; the others are at rest.
    pub velocities: Vec<(String, Vec<f64>)>,
    /// The group whose joints it places, if the file states one.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
    /// The controls of all actuators, in order; empty if the file gives none.
    pub controls: Vec<f64>,
}

impl NamedPose {
    /// A pose at rest.
    ///
    /// ```
    /// use robot_dynamics::description::{NamedPose, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.poses.push(NamedPose::new("up", [("hinge".to_owned(), vec![3.1])]));
    /// let model = Model::new(robot)?;
    /// assert_eq!(model.named_pose("up"), Some((vec![3.1], vec![0.0])));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn new(name: impl Into<String>, positions: impl IntoIterator<Item = (String, Vec<f64>)>) -> Self {
        Self { name: name.into(), positions: positions.into_iter().collect(), ..Self::default() }
    }
}
