//! From the freedoms' columns to the matrices' entries.
//!
//! For freedom j and the freedoms i of the bodies that carry its body:
//!
//! ∂τ_i/∂q_j = S_iᵀ(S_j ×\* F + I ψ′_j + 2B ψ_j),  ∂τ_j/∂q_i = (I S_j)ᵀψ′_i + (2Bᵀ S_j)ᵀψ_i,
//! ∂τ_i/∂v_j = S_iᵀ(I (Ṡ_j + ψ_j) + 2B S_j),  ∂τ_j/∂v_i = (I S_j)ᵀ(Ṡ_i + ψ_i) + (2Bᵀ S_j)ᵀS_i,
//!
//! with I, 2B and F of all beyond j. Between freedoms of one body the right-hand forms hold. So each freedom j needs
//! a few products of its own numbers with those of the freedoms on its way to the root, taken four at a time.

use dynamics::Scalar;

use super::layout::{Address, Layout};
use super::path::{LANES, SWEPT, TURN, TWICE};
use super::scratch::Scratch;
use super::tree_factor::TreeFactor;
use crate::Model;
use crate::dispatch::Route;

/// ∂τ/∂q, springs included, and ∂τ/∂v. Without followers, entries between freedoms of which neither carries the other
/// are left as they are; with followers the matrices must be zero.
#[inline(always)]
pub(super) fn write_slopes<S: Scalar, R: Route<S>>(
    model: &Model,
    scratch: &mut Scratch<R::Number>,
    by_position: &mut [S],
    by_velocity: &mut [S],
    layout: Layout,
) {
    if model.has_mimic {
        add_slopes::<S, R>(model, scratch, by_position, by_velocity, layout);
    } else {
        for (i, body) in model.bodies.iter().enumerate() {
            let last = scratch.paths.last[i];
            // Whole blocks are written. What is written for a freedom that is carried by the one at hand, or is
            // of the same body, is no entry, but what is comes later.
            let own = body.dof..body.dof + body.motion.nv();
            for dof in own.clone() {
                write_up::<S, R>(scratch, dof, last, by_position, by_velocity, layout);
            }
            for dof in own {
                write_down::<S, R>(scratch, dof, last, by_position, by_velocity, layout);
            }
        }
    }
    if model.has_springs {
        for dof in &model.dofs {
            let Address { row, column } = layout.address(dof.coordinate);
            by_position[row + column] += S::from_f64(dof.passive.stiffness * dof.ratio * dof.ratio);
        }
    }
}

/// Entries (i, j) for freedom j and the i on the way to it.
#[inline(always)]
fn write_up<S: Scalar, R: Route<S>>(
    scratch: &mut Scratch<R::Number>,
    dof: usize,
    last: usize,
    by_position: &mut [S],
    by_velocity: &mut [S],
    layout: Layout,
) {
    let Scratch { columns, paths, products: [x, y], .. } = scratch;
    let (weights, own) = (&columns[dof], layout.address(dof).column);
    let by_velocity = &mut by_velocity[..by_position.len()];
    let mut at = last;
    while let Some(block) = paths.blocks.get(at) {
        *x = block.project::<TURN, 6>(&weights.bent);
        *y = block.project::<TURN, 6>(&weights.above);
        let addresses = block.addresses(layout);
        for l in (0..LANES).rev() {
            let at = own + addresses[l].row;
            by_position[at] = R::store(x[l]);
            by_velocity[at] = R::store(y[l]);
        }
        at = block.before;
    }
}

/// Entries (j, i) for freedom j and the i on the way to it.
#[inline(always)]
fn write_down<S: Scalar, R: Route<S>>(
    scratch: &mut Scratch<R::Number>,
    dof: usize,
    last: usize,
    by_position: &mut [S],
    by_velocity: &mut [S],
    layout: Layout,
) {
    let Scratch { columns, paths, products: [x, y], .. } = scratch;
    let (weights, own) = (&columns[dof].inertial, layout.address(dof).row);
    let by_velocity = &mut by_velocity[..by_position.len()];
    let mut at = last;
    while let Some(block) = paths.blocks.get(at) {
        *x = block.project::<TWICE, 9>(weights);
        *y = block.project::<SWEPT, 9>(weights);
        let addresses = block.addresses(layout);
        for l in (0..LANES).rev() {
            let at = own + addresses[l].column;
            by_position[at] = R::store(x[l]);
            by_velocity[at] = R::store(y[l]);
        }
        at = block.before;
    }
}

/// As [`write_slopes`] where joints follow others: each entry is added to the leaders', GᵀXG.
#[inline(always)]
fn add_slopes<S: Scalar, R: Route<S>>(
    model: &Model,
    scratch: &mut Scratch<R::Number>,
    by_position: &mut [S],
    by_velocity: &mut [S],
    layout: Layout,
) {
    let Scratch { depth, columns, paths, way, .. } = scratch;
    for (body, &last) in model.bodies.iter().zip(&paths.last) {
        let own = body.dof..body.dof + body.motion.nv();
        let before = depth[own.start];
        for dof in own.clone() {
            way[depth[dof]] = dof;
        }
        for j in own.clone() {
            let (weights, at_j) = (&columns[j], layout.address(model.dofs[j].coordinate));
            let mut at = last;
            while let Some(block) = paths.blocks.get(at) {
                let down = (
                    block.project::<TWICE, 9>(&weights.inertial),
                    block.project::<SWEPT, 9>(&weights.inertial),
                );
                let up = (block.project::<TURN, 6>(&weights.bent), block.project::<TURN, 6>(&weights.above));
                let first = block.level * LANES;
                for p in first..(first + LANES).min(before + own.len()) {
                    let (other, l) = (&model.dofs[way[p]], p - first);
                    let ratio = model.dofs[j].ratio * other.ratio;
                    let at_i = layout.address(other.coordinate);
                    by_position[at_j.row + at_i.column] += R::store(down.0[l].scale(ratio));
                    by_velocity[at_j.row + at_i.column] += R::store(down.1[l].scale(ratio));
                    if p < before {
                        by_position[at_i.row + at_j.column] += R::store(up.0[l].scale(ratio));
                        by_velocity[at_i.row + at_j.column] += R::store(up.1[l].scale(ratio));
                    }
                }
                at = block.before;
            }
        }
    }
}

/// M, armature included: M_ij = S_iᵀ I S_j for each freedom j and those on the way to it.
#[inline(always)]
pub(super) fn write_mass<S: Scalar>(model: &Model, scratch: &mut Scratch<S>) {
    let Scratch { depth, columns, paths, way, reduced, mass, .. } = scratch;
    if model.has_mimic {
        mass.clear();
    }
    for (j, &depth) in depth.iter().enumerate() {
        let weights = columns[j].inertial_turn_first();
        let row = if model.has_mimic { &mut reduced[..] } else { mass.row_mut(j) };
        let mut at = paths.last[model.dofs[j].body];
        while let Some(block) = paths.blocks.get(at) {
            row[block.level] = block.project::<TURN, 6>(&weights);
            at = block.before;
        }
        if model.has_mimic {
            way[depth] = j;
            add_mass(model, &way[..=depth], reduced.as_flattened(), mass);
        }
    }
    if model.has_armature {
        for dof in &model.dofs {
            let at = mass.depth(dof.coordinate);
            mass.row_mut(dof.coordinate).as_flattened_mut()[at] +=
                S::from_f64(dof.passive.armature * dof.ratio * dof.ratio);
        }
    }
}

/// Adds the tree entries M_ij of one freedom j, the last of its way, to GᵀMG.
#[inline(always)]
fn add_mass<S: Scalar>(model: &Model, way: &[usize], entries: &[S], mass: &mut TreeFactor<S>) {
    let last = way.len() - 1;
    let own = &model.dofs[way[last]];
    for (p, (&i, &entry)) in way.iter().zip(entries).enumerate() {
        let other = &model.dofs[i];
        let entry = entry.scale(own.ratio * other.ratio);
        let (left, below) = (own.coordinate.min(other.coordinate), own.coordinate.max(other.coordinate));
        let at = &mut mass.row_mut(below).as_flattened_mut()[left];
        *at += entry;
        if left == below && p < last {
            // M_ij and M_ji.
            *at += entry;
        }
    }
}
