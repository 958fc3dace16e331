//! The state of a robot as an argument.

/// A state of the robot: configuration and velocity.
#[derive(Clone, Copy, Debug)]
pub struct RobotState<'a, S = f64> {
    /// The configuration, nq numbers.
    pub q: &'a [S],
    /// The velocity, nv numbers \[rad/s or m/s\].
    pub v: &'a [S],
}
