//! Named frames of a robot's file.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A named frame fixed to a link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct FrameDescription {
    /// Its name, unique among frames and links.
    pub name: String,
    /// The link that it is fixed to.
    pub link: String,
    /// The frame in the link's frame.
    pub link_from_frame: Pose,
}

impl FrameDescription {
    /// A frame on this link.
    ///
    /// ```
    /// use robot_dynamics::description::{FrameDescription, Pose, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.frames.push(FrameDescription::new("grip", "rod", Pose::IDENTITY));
    /// assert!(Model::new(robot)?.frame("grip").is_some());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn new(name: impl Into<String>, link: impl Into<String>, link_from_frame: Pose) -> Self {
        Self { name: name.into(), link: link.into(), link_from_frame }
    }
}
