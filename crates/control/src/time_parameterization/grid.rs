//! The grid of the path parameter.

use robot_dynamics_core::Model;

use super::sample::Sampler;
use super::{MotionLimits, ParameterizationError, TimedPath, TreePath};

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

/// The grid with the middle of every interval.
pub(super) fn halved(grid: &[f64]) -> Vec<f64> {
    let middles = grid.windows(2).flat_map(|ends| [0.5 * (ends[0] + ends[1]), ends[1]]);
    core::iter::once(grid[0]).chain(middles).collect()
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
        inside().map(|part| pair[0] + (pair[1] - pair[0]) * part).chain([pair[1]]).try_for_each(check)?;
    }
    Ok(())
}

/// The fractions of an interval before points inside it, denser towards its ends like Chebyshev points.
fn inside() -> impl Iterator<Item = f64> {
    (1..=INSIDE).map(|k| 0.5 - 0.5 * (core::f64::consts::PI * k as f64 / (INSIDE + 1) as f64).cos())
}

/// The grid of a motion with the intervals halved inside which it exceeds a limit.
pub(super) fn refined(
    model: &Model,
    path: &impl TreePath,
    timed: &TimedPath,
    limits: &MotionLimits,
) -> Vec<f64> {
    let grid = timed.grid();
    let mut sampler = Sampler::new(model, path, timed, limits.dissipation);
    let mut finer = vec![grid[0]];
    for i in 0..grid.len() - 1 {
        let middle = 0.5 * (grid[i] + grid[i + 1]);
        let can_be_halved = grid[i] < middle && middle < grid[i + 1];
        let mut passes = |part: f64| sampler.at(i, part).utilization(limits).0 > 1.0 + EXCESS;
        if can_be_halved && inside().any(&mut passes) {
            finer.push(middle);
        }
        finer.push(grid[i + 1]);
    }
    finer
}
