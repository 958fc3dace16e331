//! The Hessian of λᵀf and its products, from tangents of the pullback.

use robot_dynamics_description::check_length;

use super::lanes::{LANES, Point, SecondOrderWorkspace};
use crate::Model;
use crate::configuration::retraction_pullback::subtract_half_bracket;

/// The number of rows of nv numbers in the directions; the results must have as many.
#[track_caller]
pub(super) fn check_rows<const D: usize, const R: usize>(
    nv: usize,
    directions: [&[f64]; D],
    results: [&[f64]; R],
) -> usize {
    let rows = directions[0].len() / nv.max(1);
    for numbers in directions {
        check_length("the directions", numbers.len(), rows * nv);
    }
    for numbers in results {
        check_length("the products", numbers.len(), rows * nv);
    }
    rows
}

/// H α for each row α of the directions.
#[track_caller]
pub(super) fn multiply(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    point: &Point<'_>,
    directions: [&[f64]; 3],
    results: &mut [&mut [f64]; 3],
) {
    point.check(model, workspace);
    check_length("the cotangent", point.cotangent.len(), model.nv);
    let rows = check_rows(model.nv, directions, results.each_ref().map(|numbers| &**numbers));
    workspace.load(point);
    for first in (0..rows).step_by(LANES) {
        let count = LANES.min(rows - first);
        for lane in 0..LANES {
            // Lanes without a direction repeat the last one.
            let row = row_of(model.nv, first + lane.min(count - 1));
            workspace.set_lane(model, point.q, lane, directions.map(|numbers| &numbers[row.clone()]));
        }
        workspace.pull(model, point.map);
        let SecondOrderWorkspace { gradient, vector, .. } = workspace;
        for (value, gradient) in vector.iter_mut().zip(&gradient[0]) {
            *value = gradient.value;
        }
        for lane in 0..count {
            let row = row_of(model.nv, first + lane);
            for (to, gradient) in results.iter_mut().zip(&*gradient) {
                for (to, gradient) in to[row.clone()].iter_mut().zip(gradient) {
                    *to = gradient.gradient[lane];
                }
            }
            subtract_half_bracket(model, &directions[0][row.clone()], vector, &mut results[0][row]);
        }
    }
}

fn row_of(nv: usize, row: usize) -> core::ops::Range<usize> {
    row * nv..(row + 1) * nv
}

/// The content of the block of two positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PositionBlock {
    /// ½ (D_α g_β + D_β g_α).
    Symmetric,
    /// D_α g_β at (α, β).
    Ordered,
}

/// H, 3nv×3nv. The blocks that are zero by the linearity in the input stay zero.
#[track_caller]
pub(super) fn hessian(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    point: &Point<'_>,
    block: PositionBlock,
    hessian: &mut [f64],
) {
    point.check(model, workspace);
    let (nv, width) = (model.nv, 3 * model.nv);
    check_length("the cotangent", point.cotangent.len(), nv);
    check_length("the Hessian", hessian.len(), width * width);
    hessian.fill(0.0);
    workspace.load(point);
    for first in (0..nv).step_by(LANES) {
        let count = workspace.set_position_lanes(model, point.q, first);
        workspace.pull(model, point.map);
        let [by_position, by_velocity, by_input] = &workspace.gradient;
        for lane in 0..count {
            let row = first + lane;
            for k in 0..nv {
                let half = 0.5 * by_position[k].gradient[lane];
                hessian[row * width + k] += half;
                let (to, from) = if block == PositionBlock::Symmetric { (k, row) } else { (row, k) };
                hessian[to * width + from] += half;
                for (block, gradient) in [(nv, &by_velocity[k]), (2 * nv, &by_input[k])] {
                    hessian[row * width + block + k] = gradient.gradient[lane];
                    hessian[(block + k) * width + row] = gradient.gradient[lane];
                }
            }
        }
    }
    for first in (0..nv).step_by(LANES) {
        let count = workspace.set_velocity_lanes(nv, first);
        workspace.pull(model, point.map);
        let by_velocity = &workspace.gradient[1];
        for lane in 0..count {
            let row = nv + first + lane;
            for k in 0..nv {
                let half = 0.5 * by_velocity[k].gradient[lane];
                hessian[row * width + nv + k] += half;
                hessian[(nv + k) * width + row] += half;
            }
        }
    }
}
