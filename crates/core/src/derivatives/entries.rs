//! The matrices' entries, from the DoFs' vectors.
//!
//! Let i be a DoF of a proper ancestor of the body of DoF j:
//!
//! ∂τ_i/∂q_j = S_iᵀ(S_j ×\* F + I ψ′_j + 2B ψ_j),  ∂τ_j/∂q_i = (I S_j)ᵀψ′_i + (2Bᵀ S_j)ᵀψ_i,
//! ∂τ_i/∂v_j = S_iᵀ(I (Ṡ_j + ψ_j) + 2B S_j),  ∂τ_j/∂v_i = (I S_j)ᵀ(Ṡ_i + ψ_i) + (2Bᵀ S_j)ᵀS_i,
//!
//! with I, 2B and F of the subtree of j. Between DoFs of one body the right-hand forms hold. Each row
//! therefore consists of products of one DoF's vectors with those of four others side by side.

use core::ops::Range;

use robot_dynamics_number::Scalar;

use crate::Model;
use crate::factorization::tile::by_count;
use crate::factorization::tree_factor::TreeFactor;
use crate::workspace::derivatives::DerivativeBuffers;
use crate::workspace::dof_blocks::{DofBlock, LANES, project, turned_about};

/// ∂τ/∂q and ∂τ/∂v, row-major.
pub(super) struct DerivativeMatrices<'a, S> {
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
    /// The distance between rows.
    pub stride: usize,
}

/// Writes ∂τ/∂q, springs included, and ∂τ/∂v. If no branches are coupled, entries between DoFs on different
/// branches are left unchanged. If branches are coupled, the matrices must be zero on entry.
#[inline(always)]
pub(super) fn write_derivatives<N: Scalar>(
    model: &Model,
    blocks: &[DofBlock<N>],
    to: &mut DerivativeMatrices<'_, N>,
) {
    for block in blocks {
        write_square(model, block, to);
        let (mut below, mut own) = (block, block);
        let mut shifted;
        // Consecutive blocks with one reference point form a run, so that a block's vectors stay in
        // registers.
        'runs: loop {
            if below.shifts_reference_point {
                let next = own.shifted(&below.lever);
                shifted = next;
                own = &shifted;
            }
            loop {
                let Some(other) = blocks.get(below.before) else { break 'runs };
                for j in 0..own.tile.rows.min(LANES) {
                    let row = project(&own.inertial[j], &other.motions, 0..other.tile.rows);
                    to.put(model, own.tile.first + j, other, 0..other.tile.rows, &row);
                }
                let is_joint = own.joint_body.is_some() && own.joint_body == other.joint_body;
                for i in 0..other.tile.rows.min(LANES) {
                    let row = if is_joint {
                        project(&other.inertial[i], &own.motions, 0..own.tile.rows)
                    } else {
                        project(&other.column[i], &own.forces, 0..own.tile.rows)
                    };
                    to.put(model, other.tile.first + i, own, 0..own.tile.rows, &row);
                }
                below = other;
                if below.shifts_reference_point {
                    break;
                }
            }
        }
    }
    if model.has_springs {
        for dof in &model.dofs {
            to.by_position[dof.coordinate * (to.stride + 1)] +=
                N::from_f64(dof.passive.stiffness * dof.ratio * dof.ratio);
        }
    }
}

/// The entries between the DoFs of one block.
#[inline(always)]
fn write_square<N: Scalar>(model: &Model, own: &DofBlock<N>, to: &mut DerivativeMatrices<'_, N>) {
    let count = own.tile.rows;
    for i in 0..count.min(LANES) {
        let row = own.tile.first + i;
        if own.joint_body.is_some() {
            let entries = project(&own.inertial[i], &own.motions, 0..count);
            to.put(model, row, own, 0..count, &entries);
        } else {
            let beyond = project(&own.column[i], &own.forces, i + 1..count);
            to.put(model, row, own, i + 1..count, &beyond);
            let entries = project(&own.inertial[i], &own.motions, 0..i + 1);
            to.put(model, row, own, 0..i + 1, &entries);
        }
    }
}

impl<S: Scalar> DerivativeMatrices<'_, S> {
    /// Writes entries of one DoF's row in the first columns of a block. Columns before the block are written
    /// later. With mimic joints, entries are added to the leaders', GᵀXG.
    #[inline(always)]
    fn put(
        &mut self,
        model: &Model,
        row: usize,
        block: &DofBlock<S>,
        columns: Range<usize>,
        entries: &[S; 2 * LANES],
    ) {
        let first = block.tile.first;
        if model.needs_dense_factor {
            let own = &model.dofs[row];
            for l in columns.start..columns.end.min(LANES) {
                let other = &model.dofs[first + l];
                let (at, ratio) = (own.coordinate * self.stride + other.coordinate, own.ratio * other.ratio);
                self.by_position[at] += entries[l].scale(ratio);
                self.by_velocity[at] += entries[LANES + l].scale(ratio);
            }
        } else {
            let at = row * self.stride + first;
            let (low, high) = entries.split_at(LANES);
            by_count!(columns.end, put_first::<_>(low, &mut self.by_position[at..]));
            by_count!(columns.end, put_first::<_>(high, &mut self.by_velocity[at..]));
        }
    }
}

/// Writes the first of four numbers.
#[inline(always)]
fn put_first<S: Scalar, const COUNT: usize>(from: &[S], to: &mut [S]) {
    to[..COUNT].copy_from_slice(&from[..COUNT]);
}

/// M, armature included: M_ij = S_iᵀ I S_j for each DoF j and its ancestors i.
#[inline(always)]
pub(super) fn write_mass<S: Scalar>(model: &Model, scratch: &mut DerivativeBuffers<S>) {
    let DerivativeBuffers { paths, mass, .. } = scratch;
    if model.needs_dense_factor {
        mass.clear();
    }
    for own in &paths.blocks {
        for j in 0..own.tile.rows.min(LANES) {
            let (dof, mut weights) = (own.tile.first + j, own.inertial_turn_first(j));
            let mut next = Some(own);
            // Consecutive blocks with one reference point form a run, so that the weights stay in registers.
            while let Some(start) = next {
                let mut block = start;
                loop {
                    let entries = project(&weights, &block.columns, 0..block.tile.rows);
                    if model.needs_dense_factor {
                        add_mass(model, dof, block, &entries, mass);
                    } else {
                        // Entries beyond the diagonal are meaningless.
                        let row = &mut mass.row_mut(dof)[block.tile.depth..];
                        by_count!(block.tile.rows, put_first::<_>(&entries, row));
                    }
                    next = paths.blocks.get(block.before);
                    match next {
                        Some(before) if !block.shifts_reference_point => block = before,
                        _ => break,
                    }
                }
                if block.shifts_reference_point {
                    weights = turned_about(&block.lever, weights);
                }
            }
        }
    }
    if model.has_armature {
        for dof in &model.dofs {
            let at = mass.depth(dof.coordinate);
            mass.row_mut(dof.coordinate)[at] += S::from_f64(dof.passive.armature * dof.ratio * dof.ratio);
        }
        for (row, column, entry) in model.rotors.iter().flat_map(|rotor| rotor.entries(&model.dofs)) {
            if column <= row {
                mass.row_mut(row)[column] += S::from_f64(entry);
            }
        }
    }
}

/// Adds the tree entries M_ij of DoF j and a block of its ancestors to GᵀMG.
#[inline(always)]
fn add_mass<S: Scalar>(
    model: &Model,
    dof: usize,
    block: &DofBlock<S>,
    entries: &[S; LANES],
    mass: &mut TreeFactor<S>,
) {
    let own = &model.dofs[dof];
    let first = block.tile.first;
    for (i, &entry) in (first..=dof).zip(&entries[..block.tile.rows.min(LANES)]) {
        let other = &model.dofs[i];
        let entry = entry.scale(own.ratio * other.ratio);
        let (left, below) = (own.coordinate.min(other.coordinate), own.coordinate.max(other.coordinate));
        let at = &mut mass.row_mut(below)[left];
        *at += entry;
        if left == below && i < dof {
            // M_ij and M_ji.
            *at += entry;
        }
    }
}
