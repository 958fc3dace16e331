//! The place of a robot in a scene.

use crate::{JointKind, Pose};

/// The root link of every scene, and the root of a robot from an MJCF file.
pub(super) const WORLD: &str = "world";

/// The place of a robot in a scene, and the joint that holds it there.
#[derive(Clone, Debug, PartialEq)]
pub struct Mount {
    pub(super) parent: String,
    pub(super) parent_from_robot: Pose,
    pub(super) joint: Option<JointKind>,
    pub(super) prefix: String,
}

impl Mount {
    /// In the world: `world_from_robot` is the pose of the robot's root link at q = 0.
    pub fn at(world_from_robot: Pose) -> Self {
        Self { parent: WORLD.into(), parent_from_robot: world_from_robot, joint: None, prefix: String::new() }
    }

    /// On a link or a frame of the scene, whose frame is that of the robot's root link.
    pub fn on(parent: impl Into<String>) -> Self {
        Self { parent: parent.into(), ..Self::at(Pose::IDENTITY) }
    }

    /// With the robot's root link at this pose in the parent.
    pub fn with_pose(self, parent_from_robot: Pose) -> Self {
        Self { parent_from_robot, ..self }
    }

    /// By this joint. Without it a robot with a floating base floats, and any other is fixed.
    pub fn with_joint(self, joint: JointKind) -> Self {
        Self { joint: Some(joint), ..self }
    }

    /// The text before every name of the robot.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// With this text before every name of the robot.
    pub fn with_prefix(self, prefix: impl Into<String>) -> Self {
        Self { prefix: prefix.into(), ..self }
    }
}

/// The place of a pose in the world.
impl From<Pose> for Mount {
    fn from(world_from_robot: Pose) -> Self {
        Self::at(world_from_robot)
    }
}
