//! The fastest motion along a path, by reachability analysis.
//!
//! Source: Pham, Pham, *A new approach to time-optimal path parameterization based on reachability analysis*,
//! IEEE Transactions on Robotics 34 (2018).

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::check_length;
use robot_dynamics_number::InvalidInput;

use super::grid::{MOST_REFINEMENTS, check_position, grid, refined};
use super::half_planes::HalfPlanes;
use super::limits::{MotionLimits, ParameterizationError};
use super::{PathCoefficients, TimedPath, TreePath, path_coefficients};

/// The points of an interval at which limits are enforced; between grid points sᵢ and sᵢ₊₁ s̈ is constant and
/// ṡ² linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Collocation {
    /// At sᵢ with its s̈: limits hold at the start of every interval, and at its end up to O(Δs).
    Start,
    /// At sᵢ and sᵢ₊₁, both with the interval's s̈: limits hold on both sides of every grid point, and in
    /// between up to O(Δs²). Intervals with an excess above 1e-3 of a limit are halved.
    #[default]
    BothEnds,
}

/// The options of the fastest motion.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeOptimal {
    /// The limits of the motion.
    pub limits: MotionLimits,
    /// The largest interval of the grid is the path's length in s divided by this number. The grid also
    /// contains the path's [corners](TreePath::corners), and is refined where the limits require it.
    pub intervals: usize,
    /// The points at which the limits are enforced.
    pub collocation: Collocation,
    /// ṡ at the start \[1/s\].
    pub start_speed: f64,
    /// ṡ at the end \[1/s\].
    pub end_speed: f64,
}

impl TimeOptimal {
    /// A motion from rest to rest with this number of intervals, and limits at both ends of each.
    pub fn from_rest_to_rest(limits: MotionLimits, intervals: usize) -> Self {
        Self { limits, intervals, collocation: Collocation::default(), start_speed: 0.0, end_speed: 0.0 }
    }
}

/// The fastest motion along a path within limits of torque and velocity.
///
/// With x = ṡ² and u = s̈ constant on an interval, xᵢ₊₁ = xᵢ + 2Δ uᵢ. Every limit is a half-plane of (u, x):
/// |a u + b x + c| ≤ τ_max, |q′|² x ≤ v_max². The backward pass computes the intervals Kᵢ = {x : some
/// admissible u leads into Kᵢ₊₁}. The forward pass from x₀ takes the largest u at each point that stays
/// within them. On the grid this is the fastest motion: x is the largest at every point. **(Pham, Pham
/// 2018)**
///
/// The grid follows the path: for a spline through a thousand waypoints it has at least a thousand intervals.
/// Where a limit is exceeded inside an interval by more than 1e-3 of it, the interval is halved and the
/// motion is computed again.
///
/// ```
/// use robot_dynamics::control::{CubicSpline, MotionLimits, TimeOptimal, limit_utilization, time_optimal};
/// use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// let options = RandomRobotOptions { kinds: JointKinds::Turning, joints: 4, ..Default::default() };
/// let model = Model::new(random_robot(2, &options))?;
/// let path = CubicSpline::through(&[vec![0.0; 4], vec![0.5, -0.2, 0.8, 0.1], vec![0.2; 4]])?;
/// let limits = MotionLimits::new(vec![60.0; 4], vec![3.0; 4]);
/// let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), 200))?;
/// assert!(limit_utilization(&model, &path, &timed, &limits, 0).at_grid_points <= 1.0 + 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ParameterizationError`] if
/// - a pose is beyond the position limits, or impossible because of gravity;
/// - an end speed is unreachable, negative or not finite;
/// - no limit bounds the speed, or the path is not finite.
///
/// # Panics
/// Panics if the limits have the wrong length, or the grid has no interval.
#[track_caller]
pub fn time_optimal(
    model: &Model,
    path: &impl TreePath,
    options: &TimeOptimal,
) -> Result<TimedPath, ParameterizationError> {
    let TimeOptimal { limits, intervals: n, .. } = options;
    let n = *n;
    assert!(n > 0, "a timing needs at least one interval");
    for (place, speed) in [("start", options.start_speed), ("end", options.end_speed)] {
        if !(speed >= 0.0 && speed.is_finite()) {
            let quantity = format!("the speed ds/dt at the {place} of the path");
            return Err(InvalidInput::out_of_range(quantity, speed, "", "finite and not negative").into());
        }
    }
    check_limits(model, limits)?;
    if let Some(s) = [path.start(), path.end()].into_iter().find(|s| !s.is_finite()) {
        return Err(not_finite(s).into());
    }
    let mut grid = grid(path, n);
    check_position(model, path, limits, &grid)?;
    let mut timed = fastest_on(model, path, options, &grid)?;
    if options.collocation == Collocation::BothEnds {
        for _round in 0..MOST_REFINEMENTS {
            let finer = refined(model, path, &timed, limits);
            if finer.len() == grid.len() {
                break;
            }
            grid = finer;
            timed = fastest_on(model, path, options, &grid)?;
        }
    }
    match timed.times().iter().position(|t| !t.is_finite()) {
        Some(i) => Err(ParameterizationError::Standstill { s: timed.grid()[i.saturating_sub(1)] }),
        None => Ok(timed),
    }
}

/// The fastest motion on a grid.
fn fastest_on(
    model: &Model,
    path: &impl TreePath,
    options: &TimeOptimal,
    grid: &[f64],
) -> Result<TimedPath, ParameterizationError> {
    let (limits, n) = (&options.limits, grid.len() - 1);
    let delta = |i: usize| grid[i + 1] - grid[i];
    let stages = stages(model, path, options, grid)?;

    // Backward: the controllable sets.
    let target = options.end_speed * options.end_speed;
    let point = Stage::at_rest_of_path(&stages[n], limits);
    let (_, largest) = point.speeds().unwrap_or((0.0, -1.0));
    if largest < 0.0 {
        return Err(overloaded(model, &stages[n], limits, grid[n]));
    }
    if target > largest {
        let largest = largest.sqrt();
        return Err(ParameterizationError::EndSpeed { place: "end", speed: options.end_speed, largest });
    }
    let mut controllable = vec![(target, target); n + 1];
    for i in (0..n).rev() {
        let mut planes = stages[i].planes.clone();
        let (low, high) = controllable[i + 1];
        planes.add_between(2.0 * delta(i), 1.0, low, high);
        controllable[i] = planes.speeds().ok_or_else(|| overloaded(model, &stages[i], limits, grid[i]))?;
        if controllable[i].1 == f64::INFINITY {
            return Err(ParameterizationError::Unbounded { s: grid[i] });
        }
    }

    // Forward: as fast as the controllable sets allow.
    let mut x = vec![options.start_speed * options.start_speed];
    let (low, high) = controllable[0];
    if !(low..=high).contains(&x[0]) {
        let largest = high.sqrt();
        return Err(ParameterizationError::EndSpeed { place: "start", speed: options.start_speed, largest });
    }
    for i in 0..n {
        let (low, high) = controllable[i + 1];
        let mut planes = stages[i].planes.clone();
        planes.add_between(2.0 * delta(i), 1.0, low, high);
        let (_, u) = planes.accelerations(x[i]);
        // Rounding must not leave the controllable set.
        x.push((x[i] + 2.0 * delta(i) * u).clamp(low, high));
    }
    Ok(TimedPath::new(grid.to_vec(), x))
}

/// The constraints of one interval.
struct Stage {
    coefficients: PathCoefficients,
    /// The largest x within the velocity limits.
    largest: f64,
    planes: HalfPlanes,
}

impl Stage {
    /// The limits at a single grid point.
    fn at_rest_of_path(&self, limits: &MotionLimits) -> HalfPlanes {
        let mut planes = HalfPlanes::default();
        add_torques(&mut planes, &self.coefficients, limits, 0.0);
        planes.add(0.0, 1.0, self.largest);
        planes
    }
}

/// |a u + b (x + 2Δu) + c| ≤ τ_max at the distance Δ = `ahead` from the point of x.
fn add_torques(planes: &mut HalfPlanes, at: &PathCoefficients, limits: &MotionLimits, ahead: f64) {
    for ((a, b), (c, limit)) in at.a.iter().zip(&at.b).zip(at.c.iter().zip(&limits.torque)) {
        planes.add_between(a + 2.0 * ahead * b, *b, -limit - c, limit - c);
    }
}

fn stages(
    model: &Model,
    path: &impl TreePath,
    options: &TimeOptimal,
    grid: &[f64],
) -> Result<Vec<Stage>, ParameterizationError> {
    let workspace = &mut Workspace::new(model);
    let mut stages = Vec::with_capacity(grid.len());
    for &s in grid {
        let point = path.at(s);
        let coefficients = path_coefficients(model, workspace, &point);
        let numbers = coefficients.a.iter().chain(&coefficients.b).chain(&coefficients.c);
        let given = point.q.iter().chain(&point.dq).chain(&point.ddq);
        if numbers.chain(given).any(|x| !x.is_finite()) {
            return Err(not_finite(s).into());
        }
        let bounds = point.dq.iter().zip(&options.limits.velocity);
        let largest = bounds.filter(|(dq, _)| **dq != 0.0).map(|(dq, v)| (v / dq).powi(2));
        let largest = largest.fold(f64::INFINITY, f64::min);
        stages.push(Stage { coefficients, largest, planes: HalfPlanes::default() });
    }
    let last = stages.len() - 1;
    for i in 0..=last {
        let mut planes = stages[i].at_rest_of_path(&options.limits);
        if i < last && options.collocation == Collocation::BothEnds {
            let next = &stages[i + 1];
            add_torques(&mut planes, &next.coefficients, &options.limits, grid[i + 1] - grid[i]);
        }
        stages[i].planes = planes;
    }
    Ok(stages)
}

/// The error of a path with a number that is not finite at s.
fn not_finite(s: f64) -> InvalidInput {
    InvalidInput::unmet("the path", format!("or the torques along it are not finite at s = {s}"))
}

/// The error of a limit that is not positive, or NaN.
fn bad_limit(model: &Model, quantity: &str, index: usize, value: f64) -> InvalidInput {
    let limit = format!("the {quantity} limit of coordinate `{}`", model.coordinate_names()[index]);
    let needed = if value.is_nan() { "a number" } else { "positive" };
    InvalidInput::unmet(limit, format!("is {value}; it must be {needed}"))
}

fn check_limits(model: &Model, limits: &MotionLimits) -> Result<(), InvalidInput> {
    for (quantity, values) in [("lower", &limits.lower), ("upper", &limits.upper)] {
        check_length("the limits", values.len(), model.nv());
        if let Some(k) = values.iter().position(|x| x.is_nan()) {
            return Err(bad_limit(model, quantity, k, values[k]));
        }
    }
    for (quantity, values) in [("torque", &limits.torque), ("velocity", &limits.velocity)] {
        check_length("the limits", values.len(), model.nv());
        if let Some(k) = values.iter().position(|x| x.is_nan() || *x <= 0.0) {
            return Err(bad_limit(model, quantity, k, values[k]));
        }
    }
    Ok(())
}

/// The coordinate with the largest ratio of torque to limit at rest.
fn overloaded(model: &Model, stage: &Stage, limits: &MotionLimits, s: f64) -> ParameterizationError {
    let c = &stage.coefficients.c;
    let share = |k: usize| c[k].abs() / limits.torque[k];
    let worst = (0..c.len()).max_by(|&i, &j| share(i).total_cmp(&share(j))).unwrap_or(0);
    let coordinate = model.coordinate_names()[worst].clone();
    ParameterizationError::Overloaded { s, coordinate, needed: c[worst].abs(), limit: limits.torque[worst] }
}
