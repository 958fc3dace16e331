//! What is asked of inverse kinematics, and what it answers.

use crate::{FramePose, Pose};

/// Where a frame should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameTarget {
    /// `world_from_frame`\*: place and orientation.
    Pose(Pose),
    /// The frame's origin in the world \[m\]; its orientation is free.
    Position([f64; 3]),
}

impl From<Pose> for FrameTarget {
    fn from(pose: Pose) -> Self {
        Self::Pose(pose)
    }
}

impl From<FramePose> for FrameTarget {
    fn from(pose: FramePose) -> Self {
        Self::Pose(pose.into())
    }
}

impl From<[f64; 3]> for FrameTarget {
    fn from(position: [f64; 3]) -> Self {
        Self::Position(position)
    }
}

/// How near [`inverse_kinematics`](crate::inverse_kinematics) must come, and how long it may try.
///
/// ```
/// use multibody::InverseKinematicsOptions;
/// let options = InverseKinematicsOptions::default().with_tolerances(1e-4, 1e-3).with_restarts(100, 7);
/// assert_eq!((options.position_tolerance, options.max_restarts, options.seed), (1e-4, 100, 7));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseKinematicsOptions {
    /// How far the frame's origin may be from its target \[m\]; 1e-9 unless set.
    pub position_tolerance: f64,
    /// By which angle its orientation may be off \[rad\]; 1e-9 unless set.
    pub angle_tolerance: f64,
    /// The steps from each start; 100 unless set.
    pub max_iterations: usize,
    /// The random starts after the first; 100 unless set.
    pub max_restarts: usize,
    /// The seed of the random starts.
    pub seed: u64,
}

impl Default for InverseKinematicsOptions {
    fn default() -> Self {
        Self {
            position_tolerance: 1e-9,
            angle_tolerance: 1e-9,
            max_iterations: 100,
            max_restarts: 100,
            seed: 0,
        }
    }
}

impl InverseKinematicsOptions {
    /// With these tolerances \[m, rad\].
    pub fn with_tolerances(mut self, position: f64, angle: f64) -> Self {
        (self.position_tolerance, self.angle_tolerance) = (position, angle);
        self
    }

    /// With at most so many steps from each start.
    pub fn with_iterations(mut self, max_iterations: usize) -> Self {
        self.max_iterations = max_iterations;
        self
    }

    /// With at most so many random starts, drawn from this seed; none keeps the solution near the start.
    pub fn with_restarts(mut self, max_restarts: usize, seed: u64) -> Self {
        (self.max_restarts, self.seed) = (max_restarts, seed);
        self
    }
}

/// A configuration and how near it brings the frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseKinematicsSolution {
    /// q, nq, within the limits.
    pub q: Vec<f64>,
    /// |p − p\*| \[m\].
    pub position_error: f64,
    /// The angle of R\*ᵀR \[rad\]; 0 where the orientation is free.
    pub angle_error: f64,
    /// Steps taken from all starts.
    pub iterations: usize,
    /// Random starts tried.
    pub restarts: usize,
}
