//! From the freedoms' columns to the matrices' entries.
//!
//! For freedom i and the freedoms j of the bodies beyond its body:
//!
//! ∂τ_i/∂q_j = S_iᵀ(S_j ×\* F + I ψ′_j + 2B ψ_j),  ∂τ_j/∂q_i = (I S_j)ᵀψ′_i + (2Bᵀ S_j)ᵀψ_i,
//! ∂τ_i/∂v_j = S_iᵀ(I (Ṡ_j + ψ_j) + 2B S_j),  ∂τ_j/∂v_i = (I S_j)ᵀ(Ṡ_i + ψ_i) + (2Bᵀ S_j)ᵀS_i,
//!
//! with I, 2B and F of all beyond j. Between freedoms of one body the right-hand forms hold. A subtree is
//! numbered through: each is a run of columns times a few numbers, taken four columns at a time.

use core::ops::Range;

use dynamics::Scalar;

use crate::algebra::V3;
use crate::dispatch::Route;
use crate::workspace::{Force, Screw};
use crate::{Model, Workspace};

/// First row of S ×\* F + I ψ′ + 2B ψ.
pub(super) const BENT: usize = 0;
/// First row of I (Ṡ + ψ) + 2B S.
pub(super) const ABOVE: usize = 6;
/// First row of I S.
pub(super) const INERTIAL: usize = 12;
/// First row of the moment of 2Bᵀ S, which has no force.
pub(super) const TURNING: usize = 18;
/// How many rows there are.
pub(crate) const DERIVATIVE_ROWS: usize = 21;

/// Columns taken at a time.
const BLOCK: usize = 4;

/// The length of a row: a run of columns may be read to the end of its last block.
#[inline(always)]
pub(crate) fn padded_width(model: &Model) -> usize {
    (model.dofs.len() + BLOCK).next_multiple_of(BLOCK)
}

/// Writes a force to six rows.
#[inline(always)]
pub(super) fn write_rows<S: Scalar>(rows: &mut [S], width: usize, first: usize, at: usize, force: &Force<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    for (k, entry) in [fx, fy, fz, nx, ny, nz].into_iter().enumerate() {
        rows[(first + k) * width + at] = entry;
    }
}

/// Σₖ weightₖ row_{first+k} over a run of columns, to the same places of `line`; what lies up to three places
/// beyond the run is overwritten, too.
#[inline(always)]
fn project<S: Scalar, const K: usize>(
    rows: &[S],
    width: usize,
    first: usize,
    weights: &[S; K],
    run: Range<usize>,
    line: &mut [S],
) {
    let rows = &rows[first * width..(first + K) * width];
    let line = &mut line[..width];
    let mut at = run.start;
    while at < run.end {
        let mut sum = [S::zero(); BLOCK];
        for k in 0..K {
            let row = &rows[k * width + at..k * width + at + BLOCK];
            for l in 0..BLOCK {
                sum[l] = weights[k].mul_add(row[l], sum[l]);
            }
        }
        line[at..at + BLOCK].copy_from_slice(&sum);
        at += BLOCK;
    }
}

#[inline(always)]
fn six<S: Scalar>(s: &Screw<S>) -> [S; 6] {
    let ([a, b, c], [d, e, f]) = (s.linear.array(), s.angular.array());
    [a, b, c, d, e, f]
}

#[inline(always)]
fn nine<S: Scalar>(s: &Screw<S>, turning: V3<S>) -> [S; 9] {
    let ([a, b, c, d, e, f], [g, h, i]) = (six(s), turning.array());
    [a, b, c, d, e, f, g, h, i]
}

/// Which way a run of entries goes in a matrix.
#[derive(Clone, Copy)]
enum Run {
    /// Entries (i, j) for j in the run.
    Row,
    /// Entries (j, i) for j in the run.
    Column,
}

/// Writes entries (i, j) or (j, i) for the columns j of a run; adds them to the reduced matrix GᵀXG where
/// joints follow others.
#[inline(always)]
fn write_run<S: Scalar, R: Route<S>>(
    model: &Model,
    line: &[R::Number],
    way: Run,
    i: usize,
    run: Range<usize>,
    to: &mut [S],
    stride: usize,
) {
    if model.has_mimic {
        let a = &model.dofs[i];
        for j in run {
            let b = &model.dofs[j];
            let at = match way {
                Run::Row => a.coordinate * stride + b.coordinate,
                Run::Column => b.coordinate * stride + a.coordinate,
            };
            to[at] += R::store(line[j].scale(a.ratio * b.ratio));
        }
        return;
    }
    match way {
        Run::Row => {
            let count = run.len();
            let (to, line) = (&mut to[i * stride + run.start..][..count], &line[run][..count]);
            for j in 0..count {
                to[j] = R::store(line[j]);
            }
        }
        Run::Column => {
            for j in run {
                to[j * stride + i] = R::store(line[j]);
            }
        }
    }
}

/// The columns → ∂τ/∂q and ∂τ/∂v with rows `stride` apart; springs count in ∂τ/∂q.
#[inline(always)]
pub(super) fn write_slopes<S: Scalar, R: Route<S>>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    by_position: &mut [S],
    by_velocity: &mut [S],
    stride: usize,
) {
    by_position.fill(S::zero());
    by_velocity.fill(S::zero());
    let width = padded_width(model);
    let rows = &workspace.derivative_rows[..DERIVATIVE_ROWS * width];
    let line = &mut workspace.line[..width];
    for (i, dof) in model.dofs.iter().enumerate() {
        let body = &model.bodies[dof.body];
        let (s, slope) = (&workspace.column[i], &workspace.slope[i]);
        let (from, beyond) = (body.dof..dof.end, body.dof + body.motion.nv()..dof.end);
        let weights = nine(&slope.twice, slope.once.angular);
        project(rows, width, INERTIAL, &weights, from.clone(), line);
        write_run::<S, R>(model, line, Run::Column, i, from.clone(), by_position, stride);
        let weights = nine(&slope.swept, s.angular);
        project(rows, width, INERTIAL, &weights, from.clone(), line);
        write_run::<S, R>(model, line, Run::Column, i, from, by_velocity, stride);
        let weights = six(s);
        project(rows, width, BENT, &weights, beyond.clone(), line);
        write_run::<S, R>(model, line, Run::Row, i, beyond.clone(), by_position, stride);
        project(rows, width, ABOVE, &weights, beyond.clone(), line);
        write_run::<S, R>(model, line, Run::Row, i, beyond, by_velocity, stride);
    }
    if model.has_springs {
        for dof in &model.dofs {
            let stiffness = dof.passive.stiffness * dof.ratio * dof.ratio;
            by_position[dof.coordinate * (stride + 1)] += S::from_f64(stiffness);
        }
    }
}

/// The lower triangle of M, armature included.
#[inline(always)]
pub(super) fn write_lower_mass<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, mass: &mut [S]) {
    mass.fill(S::zero());
    let (nv, width) = (model.nv, padded_width(model));
    let rows = &workspace.derivative_rows[..DERIVATIVE_ROWS * width];
    let line = &mut workspace.line[..width];
    for (i, dof) in model.dofs.iter().enumerate() {
        project(rows, width, INERTIAL, &six(&workspace.column[i]), i..dof.end, line);
        if model.has_mimic {
            // A pair of freedoms may reduce to either triangle: both are summed.
            write_run::<S, crate::dispatch::Plain>(model, line, Run::Row, i, i + 1..dof.end, mass, nv);
        }
        write_run::<S, crate::dispatch::Plain>(model, line, Run::Column, i, i..dof.end, mass, nv);
    }
    if model.has_armature {
        for dof in &model.dofs {
            mass[dof.coordinate * (nv + 1)] += S::from_f64(dof.passive.armature * dof.ratio * dof.ratio);
        }
    }
}
