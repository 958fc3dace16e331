//! Verification of a timed path by inverse dynamics, without the coefficients of its computation.

use robot_dynamics_core::{Model, Workspace, inverse_dynamics};

use super::{MotionLimits, TimedPath, TreePath, TreePathPoint};

/// The utilization of limits by a motion; 1 is the limit itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "LimitUse")]
pub struct LimitUtilization {
    /// The largest |τ|/τ_max or |v|/v_max at grid points, on both sides of each.
    pub at_grid_points: f64,
    /// The largest utilization at the points in between.
    pub in_between: f64,
    /// The fraction of intervals with a utilization of at least 1 − 1e-6 at one of the ends.
    pub saturated: f64,
    /// The largest |τ| of each coordinate \[N·m or N\].
    pub peak_torque: Vec<f64>,
}

/// Evaluates inverse dynamics of the motion at both ends of every interval and at `between` points inside it.
///
/// ```
/// use robot_dynamics::control::{CubicSpline, MotionLimits, TimeOptimal, limit_utilization, time_optimal};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let path = CubicSpline::through(&[vec![0.0], vec![1.0]])?;
/// let limits = MotionLimits::new(vec![12.0], vec![2.0]);
/// let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), 200))?;
/// // The fastest motion is always at a limit; with motors twice as strong the utilization is a half.
/// let used = limit_utilization(&model, &path, &timed, &limits, 3);
/// assert!((used.at_grid_points - 1.0).abs() < 1e-9 && used.saturated > 0.95);
/// assert!((used.peak_torque[0] - 12.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a length is wrong.
#[track_caller]
#[doc(alias = "limit_use")]
pub fn limit_utilization(
    model: &Model,
    path: &impl TreePath,
    timed: &TimedPath,
    limits: &MotionLimits,
    between: usize,
) -> LimitUtilization {
    let workspace = &mut Workspace::new(model);
    let mut found = LimitUtilization {
        at_grid_points: 0.0,
        in_between: 0.0,
        saturated: 0.0,
        peak_torque: vec![0.0; model.nv()],
    };
    let mut tau = vec![0.0; model.nv()];
    let (grid, x) = (timed.grid(), timed.squared_speeds());
    let intervals = grid.len() - 1;
    for i in 0..intervals {
        let acceleration = timed.acceleration(i);
        let mut largest_at_ends = 0.0f64;
        for j in 0..between + 2 {
            let part = j as f64 / (between + 1) as f64;
            let square = x[i] + (x[i + 1] - x[i]) * part;
            let TreePathPoint { q, dq, ddq } = path.at(grid[i] + (grid[i + 1] - grid[i]) * part);
            let v: Vec<f64> = dq.iter().map(|dq| dq * square.sqrt()).collect();
            let a: Vec<f64> = dq.iter().zip(&ddq).map(|(dq, ddq)| dq * acceleration + ddq * square).collect();
            inverse_dynamics(model, workspace, &q, &v, &a, &mut tau);
            let mut largest = 0.0f64;
            for k in 0..model.nv() {
                found.peak_torque[k] = found.peak_torque[k].max(tau[k].abs());
                largest = largest.max(tau[k].abs() / limits.torque[k]).max(v[k].abs() / limits.velocity[k]);
            }
            if j == 0 || j == between + 1 {
                largest_at_ends = largest_at_ends.max(largest);
            } else {
                found.in_between = found.in_between.max(largest);
            }
        }
        found.at_grid_points = found.at_grid_points.max(largest_at_ends);
        if largest_at_ends >= 1.0 - 1e-6 {
            found.saturated += 1.0 / intervals as f64;
        }
    }
    found
}
