//! Verification of a timed path by inverse dynamics, without the coefficients of its computation.

use robot_dynamics_core::Model;

use super::sample::Sampler;
use super::{LimitedQuantity, MotionLimits, TimedPath, TreePath};

/// The place of the largest utilization of a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TightestLimit {
    /// The quantity that is limited.
    pub quantity: LimitedQuantity,
    /// The coordinate, as its index in v.
    pub coordinate: usize,
    /// The path parameter.
    pub s: f64,
    /// The utilization there; 1 is the limit itself.
    pub utilization: f64,
}

/// The utilization of limits by a motion; 1 is the limit itself.
///
/// The utilization of a torque is 1 + e/m, where e is its signed excess over the range and m the larger
/// magnitude of the range's ends. For a symmetric range this is |τ|/τ_max.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "LimitUse")]
pub struct LimitUtilization {
    /// The largest utilization of torque, velocity, acceleration or power at grid points, on both sides of
    /// each.
    pub at_grid_points: f64,
    /// The largest utilization at the points in between.
    pub in_between: f64,
    /// The fraction of intervals with a utilization of at least 1 − 1e-6 at one of the ends.
    pub saturated: f64,
    /// The quantity, coordinate and place with the largest utilization of all.
    pub tightest: TightestLimit,
    /// The largest |τ| of each coordinate \[N·m or N\].
    pub peak_torque: Vec<f64>,
    /// The largest |v| of each coordinate \[rad/s or m/s\].
    pub peak_velocity: Vec<f64>,
    /// The largest |a| of each coordinate \[rad/s² or m/s²\].
    pub peak_acceleration: Vec<f64>,
    /// The largest |τ v| of each coordinate \[W\].
    pub peak_power: Vec<f64>,
}

/// Evaluates inverse dynamics of the motion at both ends of every interval and at `between` points inside it.
///
/// Damping and friction of the joints belong to τ as [`MotionLimits::dissipation`] says. Friction at rest has
/// the direction of the motion that begins or ends there.
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
    let peaks = || vec![0.0; model.nv()];
    let mut found = LimitUtilization {
        at_grid_points: 0.0,
        in_between: 0.0,
        saturated: 0.0,
        tightest: TightestLimit {
            quantity: LimitedQuantity::Torque,
            coordinate: 0,
            s: timed.grid()[0],
            utilization: 0.0,
        },
        peak_torque: peaks(),
        peak_velocity: peaks(),
        peak_acceleration: peaks(),
        peak_power: peaks(),
    };
    let mut sampler = Sampler::new(model, path, timed, limits.dissipation);
    let intervals = timed.grid().len() - 1;
    for i in 0..intervals {
        let mut largest_at_ends = 0.0f64;
        for j in 0..between + 2 {
            let sample = sampler.at(i, j as f64 / (between + 1) as f64);
            for k in 0..model.nv() {
                let raise = |peak: &mut f64, value: f64| *peak = peak.max(value.abs());
                raise(&mut found.peak_torque[k], sample.tau[k]);
                raise(&mut found.peak_velocity[k], sample.v[k]);
                raise(&mut found.peak_acceleration[k], sample.a[k]);
                raise(&mut found.peak_power[k], sample.tau[k] * sample.v[k]);
            }
            let (utilization, quantity, coordinate) = sample.utilization(limits);
            if utilization > found.tightest.utilization {
                found.tightest = TightestLimit { quantity, coordinate, s: sample.s, utilization };
            }
            if j == 0 || j == between + 1 {
                largest_at_ends = largest_at_ends.max(utilization);
            } else {
                found.in_between = found.in_between.max(utilization);
            }
        }
        found.at_grid_points = found.at_grid_points.max(largest_at_ends);
        if largest_at_ends >= 1.0 - 1e-6 {
            found.saturated += 1.0 / intervals as f64;
        }
    }
    found
}
