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

use super::column_block::{ABOVE, BENT, INERTIAL, LANES};
use super::slope_block::{SlopeBlock, WIDTH};
use crate::algebra::V3;
use crate::workspace::Screw;
use crate::{Model, Workspace};

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

/// The blocks that hold a run of columns.
#[inline(always)]
fn blocks(run: &Range<usize>) -> Range<usize> {
    if run.is_empty() { 0..0 } else { run.start / LANES..run.end.div_ceil(LANES) }
}

/// The entries of block `b` that belong to a run of columns; zeros for the others.
#[inline(always)]
fn masked<S: Scalar>(entries: &[S; LANES], b: usize, run: &Range<usize>) -> [S; LANES] {
    let mut masked = *entries;
    for l in 0..LANES {
        let j = b * LANES + l;
        masked[l] = if run.start <= j && j < run.end { masked[l] } else { S::zero() };
    }
    masked
}

/// The columns → ∂τ/∂q and ∂τ/∂v in `workspace.slope_block`; springs count in ∂τ/∂q.
#[inline(always)]
pub(super) fn write_slopes<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    if model.has_mimic {
        // Entries add up there. Else all entries between freedoms of which one carries the other are written, and
        // the rest have been zero since the memory was made.
        workspace.slope_block.fill(SlopeBlock::zero());
    }
    // Whole blocks are written, with zeros beside a run. No number is lost by it: beside a body's runs lie zeros
    // of the result, the body's own columns, and the runs of bodies that carry it, which come later.
    for body in model.bodies.iter().rev() {
        let own = body.dof..body.dof + body.motion.nv();
        for i in own.clone() {
            let beyond = own.end..model.dofs[i].end;
            let s = six(&workspace.column[i]);
            for b in blocks(&beyond) {
                let block = &workspace.column_block[b];
                let x = masked(&block.project::<BENT, 6>(&s), b, &beyond);
                let y = masked(&block.project::<ABOVE, 6>(&s), b, &beyond);
                write_row(model, &mut workspace.slope_block, i, b, &x, &y);
            }
        }
        for i in own.clone() {
            let from = own.start..model.dofs[i].end;
            let slope = &workspace.slope[i];
            let by_position = nine(&slope.twice, slope.once.angular);
            let by_velocity = nine(&slope.swept, workspace.column[i].angular);
            for b in blocks(&from) {
                let block = &workspace.column_block[b];
                let x = masked(&block.project::<INERTIAL, 9>(&by_position), b, &from);
                let y = masked(&block.project::<INERTIAL, 9>(&by_velocity), b, &from);
                write_column(model, &mut workspace.slope_block, i, b, &x, &y);
            }
        }
    }
    if model.has_springs {
        for dof in &model.dofs {
            let stiffness = S::from_f64(dof.passive.stiffness * dof.ratio * dof.ratio);
            let at = dof.coordinate;
            workspace.slope_block[at / WIDTH * model.nv + at].by_position[at % WIDTH] += stiffness;
        }
    }
}

/// Entries (i, j) for the columns j of block `b`.
#[inline(always)]
fn write_row<S: Scalar>(
    model: &Model,
    to: &mut [SlopeBlock<S>],
    i: usize,
    b: usize,
    x: &[S; LANES],
    y: &[S; LANES],
) {
    if model.has_mimic {
        for l in 0..LANES.min(model.dofs.len() - b * LANES) {
            add_reduced(model, to, (i, b * LANES + l), x[l], y[l]);
        }
        return;
    }
    let at = b * LANES;
    let (block, lane) = (&mut to[at / WIDTH * model.nv + i], at % WIDTH);
    block.by_position[lane..lane + LANES].copy_from_slice(x);
    block.by_velocity[lane..lane + LANES].copy_from_slice(y);
}

/// Entries (j, i) for the rows j of block `b`.
#[inline(always)]
fn write_column<S: Scalar>(
    model: &Model,
    to: &mut [SlopeBlock<S>],
    i: usize,
    b: usize,
    x: &[S; LANES],
    y: &[S; LANES],
) {
    let count = LANES.min(model.dofs.len() - b * LANES);
    if model.has_mimic {
        for l in 0..count {
            add_reduced(model, to, (b * LANES + l, i), x[l], y[l]);
        }
        return;
    }
    let rows = &mut to[i / WIDTH * model.nv + b * LANES..][..count];
    for (l, block) in rows.iter_mut().enumerate() {
        block.by_position[i % WIDTH] = x[l % LANES];
        block.by_velocity[i % WIDTH] = y[l % LANES];
    }
}

/// Adds tree entry (i, j) to the reduced matrices GᵀXG and GᵀYG.
#[inline(always)]
fn add_reduced<S: Scalar>(model: &Model, to: &mut [SlopeBlock<S>], (i, j): (usize, usize), x: S, y: S) {
    let (a, b) = (&model.dofs[i], &model.dofs[j]);
    let ratio = a.ratio * b.ratio;
    let block = &mut to[b.coordinate / WIDTH * model.nv + a.coordinate];
    block.by_position[b.coordinate % WIDTH] += x.scale(ratio);
    block.by_velocity[b.coordinate % WIDTH] += y.scale(ratio);
}

/// The lower triangle of M, row-major, armature included, as [`factor`](crate::sparse_cholesky::factor) reads
/// it: where no joint follows another, entries between freedoms that do not carry each other are left as they are.
#[inline(always)]
pub(super) fn write_lower_mass<S: Scalar>(model: &Model, workspace: &Workspace<S>, mass: &mut [S]) {
    if model.has_mimic {
        mass.fill(S::zero());
    }
    let nv = model.nv;
    for (i, dof) in model.dofs.iter().enumerate() {
        let s = six(&workspace.column[i]);
        for b in blocks(&(i..dof.end)) {
            let entries = workspace.column_block[b].project::<INERTIAL, 6>(&s);
            let (from, end) = (i.max(b * LANES), dof.end.min((b + 1) * LANES));
            for j in from..end {
                let entry = entries[j % LANES];
                if model.has_mimic {
                    let other = &model.dofs[j];
                    let entry = entry.scale(dof.ratio * other.ratio);
                    mass[other.coordinate * nv + dof.coordinate] += entry;
                    if j != i {
                        // Either triangle of the tree's M may fall on the reduced one's lower.
                        mass[dof.coordinate * nv + other.coordinate] += entry;
                    }
                } else {
                    mass[j * nv + i] = entry;
                }
            }
        }
    }
    if model.has_armature {
        for dof in &model.dofs {
            mass[dof.coordinate * (nv + 1)] += S::from_f64(dof.passive.armature * dof.ratio * dof.ratio);
        }
    }
}
