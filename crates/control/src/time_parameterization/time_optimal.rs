//! The fastest motion along a path: its options, its grid and its iterations.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

use super::grid::{MOST_REFINEMENTS, check_position, grid, halved, refined};
use super::reachability::Problem;
use super::{MotionLimits, ParameterizationError, TimedPath, TreePath};

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
    /// All intervals are halved until that changes the duration by less than this fraction of it. If
    /// infinite, the first duration is the result.
    pub duration_tolerance: f64,
}

impl TimeOptimal {
    /// A motion from rest to rest on a grid that the error decides. Between grid points no limit is exceeded
    /// by more than 1e-3 of it. Halving all intervals changes the duration by less than 5e-3.
    ///
    /// ```
    /// use robot_dynamics::control::{CubicSpline, MotionLimits, TimeOptimal, time_optimal};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let path = CubicSpline::through(&[vec![0.0], vec![1.0]])?;
    /// let limits = MotionLimits::new(vec![12.0], vec![2.0]);
    /// let timed = time_optimal(&model, &path, &TimeOptimal::new(limits.clone()))?;
    /// let fine = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits, 4000))?;
    /// assert!((timed.duration() / fine.duration() - 1.0).abs() < 1e-2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(limits: MotionLimits) -> Self {
        Self { duration_tolerance: 5e-3, ..Self::from_rest_to_rest(limits, FIRST_INTERVALS) }
    }

    /// A motion from rest to rest with at least this number of intervals, and limits at both ends of each.
    pub fn from_rest_to_rest(limits: MotionLimits, intervals: usize) -> Self {
        Self {
            limits,
            intervals,
            collocation: Collocation::default(),
            start_speed: 0.0,
            end_speed: 0.0,
            duration_tolerance: f64::INFINITY,
        }
    }
}

/// The number of intervals from which [`TimeOptimal::new`] refines.
const FIRST_INTERVALS: usize = 50;

/// The limit of rounds in which all intervals are halved.
const MOST_HALVINGS: usize = 8;

/// The fastest motion along a path within limits of torque, velocity, acceleration and power.
///
/// With x = ṡ² and u = s̈ constant on an interval, xᵢ₊₁ = xᵢ + 2Δ uᵢ. Limits are half-planes of (u, x):
/// τ_min ≤ a u + b x + c ≤ τ_max, |q′|² x ≤ v_max², |q′ u + q″ x| ≤ a_max. The backward pass computes the
/// intervals Kᵢ = {x : some admissible u leads into Kᵢ₊₁}. The forward pass from x₀ takes the largest u at
/// each point that stays within them. On a fine grid this is the fastest motion: x is the largest at every
/// point. **(Pham, Pham 2018)**
///
/// Dry friction adds friction · sign q′ to c. Damping adds damping · q′ √x to τ, and a limit of power is
/// |τ q′| ≤ P/√x. These are not linear. They are linearised on the conservative side at the last solution,
/// and the motion is computed again until its duration falls by less than 1e-9 of itself. Each iteration
/// obeys the limits, and on a fine grid it is not slower than the one before (the convex-concave procedure).
/// The result is a local optimum, because damping makes the feasible set nonconvex.
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
    let TimeOptimal { limits, intervals, .. } = options;
    assert!(*intervals > 0, "a timing needs at least one interval");
    for (place, speed) in [("start", options.start_speed), ("end", options.end_speed)] {
        if !(speed >= 0.0 && speed.is_finite()) {
            let quantity = format!("the speed ds/dt at the {place} of the path");
            return Err(InvalidInput::out_of_range(quantity, speed, "", "finite and not negative").into());
        }
    }
    limits.check(model)?;
    if let Some(s) = [path.start(), path.end()].into_iter().find(|s| !s.is_finite()) {
        return Err(not_finite(s).into());
    }
    let mut grid = grid(path, *intervals);
    check_position(model, path, limits, &grid)?;
    let mut timed = fastest_on(&problem(model, path, options, &grid)?, None)?;
    timed = within_limits(model, path, options, &mut grid, timed)?;
    for _halving in 0..MOST_HALVINGS {
        if !options.duration_tolerance.is_finite() {
            break;
        }
        let before = timed.duration();
        grid = halved(&grid);
        timed = fastest_on(&problem(model, path, options, &grid)?, Some(&timed))?;
        timed = within_limits(model, path, options, &mut grid, timed)?;
        if (timed.duration() - before).abs() <= options.duration_tolerance * timed.duration() {
            break;
        }
    }
    match timed.times().iter().position(|t| !t.is_finite()) {
        Some(i) => Err(ParameterizationError::Standstill { s: timed.grid()[i.saturating_sub(1)] }),
        None => Ok(timed),
    }
}

/// Refines the grid of a motion until no limit is exceeded inside an interval.
fn within_limits(
    model: &Model,
    path: &impl TreePath,
    options: &TimeOptimal,
    grid: &mut Vec<f64>,
    mut timed: TimedPath,
) -> Result<TimedPath, ParameterizationError> {
    if options.collocation == Collocation::Start {
        return Ok(timed);
    }
    for _round in 0..MOST_REFINEMENTS {
        let finer = refined(model, path, &timed, &options.limits);
        if finer.len() == grid.len() {
            break;
        }
        *grid = finer;
        timed = fastest_on(&problem(model, path, options, grid)?, Some(&timed))?;
    }
    Ok(timed)
}

fn problem<'a>(
    model: &'a Model,
    path: &impl TreePath,
    options: &'a TimeOptimal,
    grid: &'a [f64],
) -> Result<Problem<'a>, ParameterizationError> {
    let problem = Problem::new(model, path, &options.limits, grid).map_err(not_finite)?;
    let both_ends = options.collocation == Collocation::BothEnds;
    Ok(problem.with_end_speeds(options.start_speed, options.end_speed).with_both_ends(both_ends))
}

/// The limit of iterations of the convex-concave procedure, and of attempts to find a feasible motion.
const MOST_ITERATIONS: usize = 60;

/// Iterations end when the duration falls by less than this fraction of itself.
const CONVERGED: f64 = 1e-9;

/// A reference that obeys no motion is replaced by one with this fraction of its x.
const SLOWER: f64 = 0.25;

/// The fastest motion on the grid of a problem, with the solution on a coarser grid as the first reference.
fn fastest_on(problem: &Problem<'_>, coarse: Option<&TimedPath>) -> Result<TimedPath, ParameterizationError> {
    let timed = |x: Vec<f64>| TimedPath::new(problem.grid().to_vec(), x);
    if !problem.has_roots() {
        return Ok(timed(problem.solve(None)?));
    }
    let mut reference = match coarse {
        Some(coarse) => problem.grid().iter().map(|&s| coarse.squared_speed(s)).collect(),
        None => match problem.solve(None) {
            Ok(x) => x,
            // The limit of power alone may bound the speed. The iterations increase a slow reference.
            Err(ParameterizationError::Unbounded { .. }) => problem.one_second(),
            Err(error) => return Err(error),
        },
    };
    let mut attempts = 0;
    let mut best = loop {
        match problem.solve(Some(&reference)) {
            Ok(x) => break timed(x),
            Err(error) if attempts == MOST_ITERATIONS => return Err(error),
            Err(_) => reference.iter_mut().for_each(|x| *x *= SLOWER),
        }
        attempts += 1;
    };
    for _iteration in 0..MOST_ITERATIONS {
        // Rounding may turn a reference at its limits into an infeasible one.
        let Ok(x) = problem.solve(Some(best.squared_speeds())) else { break };
        let next = timed(x);
        let (before, after) = (best.duration(), next.duration());
        if after < before || !before.is_finite() {
            best = next;
        }
        if after >= before * (1.0 - CONVERGED) {
            break;
        }
    }
    Ok(best)
}

/// The error of a path with a number that is not finite at s.
fn not_finite(s: f64) -> InvalidInput {
    InvalidInput::unmet("the path", format!("or the torques along it are not finite at s = {s}"))
}
