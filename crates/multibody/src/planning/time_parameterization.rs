//! A path gets its clock: torques along a path, and the fastest motion on it within the robot's limits.
//!
//! A path q(s) has no clock. With one, v = q′ ṡ and a = q′ s̈ + q″ ṡ², the torques are
//! a(s) s̈ + b(s) ṡ² + c(s) = τ, linear in u = s̈ and x = ṡ² **(PRM ch. 11; MR §9.4)**. Limits of torque and
//! velocity at s are therefore half-planes of (u, x), and since x′ = 2 s̈ the fastest motion is found by one
//! sweep backward (which x can still stop in time?) and one forward (as fast as that allows).

mod coefficients;
mod grid;
mod half_planes;
mod limits;
mod path;
mod reachability;
mod spline;
mod timed_path;
mod verification;

pub use coefficients::{PathCoefficients, path_coefficients};
pub use limits::{MotionLimits, ParameterizationError};
pub use path::{TreePath, TreePathPoint};
pub use reachability::{Collocation, TimeOptimal, time_optimal};
pub use spline::{CubicSpline, SplineError};
pub use timed_path::{PathMoment, TimedPath};
pub use verification::{LimitUse, limit_use};
