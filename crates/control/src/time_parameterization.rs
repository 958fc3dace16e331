//! Time parameterization: torques along a path, and the fastest motion along it within the robot's limits.
//!
//! A path q(s) has no time law. With one, v = q′ ṡ and a = q′ s̈ + q″ ṡ². The torques are a(s) s̈ + b(s) ṡ² +
//! c(s) = τ, linear in u = s̈ and x = ṡ² **(PRM ch. 11; MR §9.4)**. Limits of torque, velocity and
//! acceleration at s are therefore half-planes of (u, x), and x′ = 2 s̈. Damping and power have terms with √x,
//! which are linearised at the last solution. A backward pass finds the values of x from which the
//! motion can still stop in time. A forward pass takes the largest of them.
//!
//! Cost: O(n) for the coefficients of each grid point, and the intersection of half-planes there.
//! Limits hold at grid points; the grid is refined where they are exceeded between these. Jerk is not
//! limited.

mod coefficients;
mod configuration_spline;
mod constraints;
mod error;
mod grid;
mod half_planes;
mod limits;
mod path;
mod reachability;
mod rotation_spline;
mod sample;
mod sampling;
mod spline;
mod time_optimal;
mod timed_path;
mod utilization;

pub use coefficients::{PathCoefficients, path_coefficients};
pub use configuration_spline::ConfigurationSpline;
pub use error::ParameterizationError;
pub use limits::{LimitedQuantity, MotionLimits};
pub use path::{TreePath, TreePathPoint};
pub use spline::CubicSpline;
pub use time_optimal::{Collocation, TimeOptimal, time_optimal};
pub use timed_path::{PathState, TimedPath};
pub use utilization::{LimitUtilization, TightestLimit, limit_utilization};
