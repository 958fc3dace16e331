//! The frames that a constraint joins, and the directions along which it joins them.

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::equality::site::Site;

/// One side of a closure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// A frame of the robot.
    Frame(FrameId),
    /// A pose in the world: `world_from_anchor`.
    World(Pose),
}

impl Anchor {
    #[track_caller]
    pub(super) fn site(&self, model: &Model) -> Site {
        match self {
            Self::Frame(frame) => Site::of_frame(model, *frame),
            Self::World(pose) => Site::in_world(pose),
        }
    }
}

/// A direction in which frame b must not move relative to frame a, in the axes of a.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[doc(alias = "ClosureRow")]
pub enum SpatialAxis {
    /// Along x \[m\].
    X,
    /// Along y \[m\].
    Y,
    /// Along z \[m\].
    Z,
    /// Rotation about x \[rad\].
    Rx,
    /// Rotation about y \[rad\].
    Ry,
    /// Rotation about z \[rad\].
    Rz,
}

impl SpatialAxis {
    /// The name in a loop's file: `x`, ..., `rz`.
    pub fn name(self) -> &'static str {
        ["x", "y", "z", "rx", "ry", "rz"][self as usize]
    }

    /// Whether the row constrains a rotation.
    pub fn is_turn(self) -> bool {
        self as usize >= 3
    }

    /// 0, 1, 2 for x, y, z.
    pub(super) fn axis(self) -> usize {
        self as usize % 3
    }
}
