//! Inputs and results of inverse kinematics.

use robot_dynamics_description::Pose;

/// The target of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameTarget {
    /// `world_from_frame`\*: position and orientation.
    Pose(Pose),
    /// The frame's origin in the world \[m\]; its orientation is free.
    Position([f64; 3]),
}

impl From<Pose> for FrameTarget {
    fn from(pose: Pose) -> Self {
        Self::Pose(pose)
    }
}

impl From<[f64; 3]> for FrameTarget {
    fn from(position: [f64; 3]) -> Self {
        Self::Position(position)
    }
}

/// The tolerances and the limits of iterations of [`inverse_kinematics`](crate::inverse_kinematics).
///
/// ```
/// use robot_dynamics::control::InverseKinematicsOptions;
/// let options = InverseKinematicsOptions::default().with_tolerances(1e-4, 1e-3).with_restarts(100, 7);
/// assert_eq!((options.position_tolerance, options.max_restarts, options.seed), (1e-4, 100, 7));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseKinematicsOptions {
    /// The allowed distance of the frame's origin from its target \[m\]; the default is 1e-9.
    pub position_tolerance: f64,
    /// The allowed angle of its orientation from the target \[rad\]; the default is 1e-9.
    pub angle_tolerance: f64,
    /// The most steps from each start; the default is 100.
    pub max_iterations: usize,
    /// The most random starts after the first; the default is 100.
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
    /// Sets the tolerances \[m, rad\].
    pub fn with_tolerances(mut self, position: f64, angle: f64) -> Self {
        (self.position_tolerance, self.angle_tolerance) = (position, angle);
        self
    }

    /// Sets the most steps from each start.
    pub fn with_iterations(mut self, max_iterations: usize) -> Self {
        self.max_iterations = max_iterations;
        self
    }

    /// Sets the most random starts and their seed; with 0 the solution remains near the start.
    pub fn with_restarts(mut self, max_restarts: usize, seed: u64) -> Self {
        (self.max_restarts, self.seed) = (max_restarts, seed);
        self
    }
}

/// A configuration and its distance from the target.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseKinematicsSolution {
    /// q, nq numbers, within the limits.
    pub q: Vec<f64>,
    /// |p − p\*| \[m\].
    pub position_error: f64,
    /// The angle of R\*ᵀR \[rad\]; 0 if the orientation is free.
    pub angle_error: f64,
    /// The number of steps from all starts.
    pub iterations: usize,
    /// The number of random starts.
    pub restarts: usize,
}
