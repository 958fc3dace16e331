//! Where along a path the speeds are computed.

use super::{MotionLimits, ParameterizationError, TimedPath, TreePath, TreePathPoint};
use crate::{Model, Workspace, inverse_dynamics};

/// Rounds of halving intervals; each takes a quarter, or of a corner a half, of what limits are passed by.
pub(super) const MOST_REFINEMENTS: usize = 12;

/// A limit that is passed between grid points by more than this part of it makes the grid finer there.
const EXCESS: f64 = 1e-3;

/// Points inside an interval at which limits are looked at.
const INSIDE: usize = 9;

/// Through the path's ends and corners, and in between in equal parts not longer than the path divided by `count`.
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

/// The least whole number that is not below this share, but for its rounding; one at least.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most the number of intervals asked for
fn parts(share: f64) -> usize {
    ((share * (1.0 - 1e-12)).ceil() as usize).max(1)
}

/// Refuses a path that is beyond the limits of position at a grid point or between two.
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

/// Points inside an interval, denser towards its ends as Chebyshev's are, and which part of it lies before each.
fn inside(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    (1..=INSIDE).map(move |k| {
        let part = 0.5 - 0.5 * (core::f64::consts::PI * k as f64 / (INSIDE + 1) as f64).cos();
        (from + (to - from) * part, part)
    })
}

/// The grid of a motion with those intervals halved in which it passes a limit between the ends.
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
