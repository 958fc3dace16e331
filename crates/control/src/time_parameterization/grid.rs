//! The grid of the path parameter.

use robot_dynamics_core::{Model, Workspace, inverse_dynamics};

use super::{MotionLimits, ParameterizationError, TimedPath, TreePath, TreePathPoint};

/// The limit of refinements by halving intervals. Each one reduces the excess over limits to a quarter, or to
/// a half at a corner.
pub(super) const MOST_REFINEMENTS: usize = 12;

/// The grid is refined where a limit is exceeded between grid points by more than this fraction of it.
const EXCESS: f64 = 1e-3;

/// The number of points inside an interval at which limits are checked.
const INSIDE: usize = 9;

/// A grid through the path's ends and corners, with equal intervals in between that are not longer than the
/// path divided by `count`.
pub(super) fn grid(path: &impl TreePath, count: usize) -> Vec<f64> {
    let (start, end) = (path.start(), path.end());
    let corners = path.corners().iter().copied().filter(|&s| start < s && s < end);
    let mut ends: Vec<f64> = corners.chain([end]).collect();
    ends.dedup();
    let mut grid = vec![start];
    let mut from = start;
    for to in ends {
        let parts = parts((to - from) / (end - start) * count as f64);
        grid.extend((1..=parts).map(|part| from + (to - from) * part as f64 / parts as f64));
        from = to;
    }
    grid
}

/// The ratio rounded up to a whole number, with tolerance for rounding, and at least one.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most the requested intervals
fn parts(share: f64) -> usize {
    ((share * (1.0 - 1e-12)).ceil() as usize).max(1)
}

/// Checks the path against the position limits at grid points and between them.
pub(super) fn check_position(
    model: &Model,
    path: &impl TreePath,
    limits: &MotionLimits,
    grid: &[f64],
) -> Result<(), ParameterizationError> {
    let check = |s: f64| match limits.position_beyond(model, &path.at(s).q) {
        None => Ok(()),
        Some((k, value)) => Err(ParameterizationError::BeyondPosition {
            s,
            coordinate: model.coordinate_names()[k].clone(),
            value,
            lower: limits.lower[k],
            upper: limits.upper[k],
        }),
    };
    check(grid[0])?;
    for pair in grid.windows(2) {
        inside(pair[0], pair[1]).map(|(s, _)| s).chain([pair[1]]).try_for_each(check)?;
    }
    Ok(())
}

/// Points inside an interval, denser towards its ends like Chebyshev points, with the fraction of the
/// interval before each.
fn inside(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    (1..=INSIDE).map(move |k| {
        let part = 0.5 - 0.5 * (core::f64::consts::PI * k as f64 / (INSIDE + 1) as f64).cos();
        (from + (to - from) * part, part)
    })
}

/// The grid of a motion with the intervals halved inside which it exceeds a limit.
pub(super) fn refined(
    model: &Model,
    path: &impl TreePath,
    timed: &TimedPath,
    limits: &MotionLimits,
) -> Vec<f64> {
    let workspace = &mut Workspace::new(model);
    let mut tau = vec![0.0; model.nv()];
    let (grid, x) = (timed.grid(), timed.squared_speeds());
    let mut finer = vec![grid[0]];
    for i in 0..grid.len() - 1 {
        let acceleration = timed.acceleration(i);
        let mut passes = |(s, part): (f64, f64)| {
            let square = x[i] + (x[i + 1] - x[i]) * part;
            let TreePathPoint { q, dq, ddq } = path.at(s);
            let v: Vec<f64> = dq.iter().map(|dq| dq * square.sqrt()).collect();
            let a: Vec<f64> = dq.iter().zip(&ddq).map(|(dq, ddq)| dq * acceleration + ddq * square).collect();
            inverse_dynamics(model, workspace, &q, &v, &a, &mut tau);
            let beyond = |(x, limit): (&f64, &f64)| x.abs() > limit * (1.0 + EXCESS);
            tau.iter().zip(&limits.torque).any(beyond) || v.iter().zip(&limits.velocity).any(beyond)
        };
        let middle = 0.5 * (grid[i] + grid[i + 1]);
        let can_be_halved = grid[i] < middle && middle < grid[i + 1];
        if can_be_halved && inside(grid[i], grid[i + 1]).any(&mut passes) {
            finer.push(middle);
        }
        finer.push(grid[i + 1]);
    }
    finer
}
