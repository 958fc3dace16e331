//! The pivots of M_y = GᵀM G = LᵀD L, for robots whose branches are coupled by mimic joints or tendons'
//! armature.

use super::bodies::{add_shifted, place, response};
use super::vanished_pivot::{VanishedPivot, is_clear, vanishes};
use crate::Model;
use crate::model::WORLD;
use crate::spatial::force::ForceVector;
use crate::workspace::extent::RankBuffers;
use crate::workspace::tree::TreeMemory;

/// Calls `on_vanished` for the pivots of M_y(q) that vanish.
///
/// A coordinate that moves the DoFs i by ratios rᵢ has √N = Σ |rᵢ| √Nᵢ.
pub(super) fn eliminate(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut RankBuffers,
    q: &[f64],
    bound: f64,
    on_vanished: &mut dyn FnMut(&VanishedPivot<'_>),
) {
    place(model, tree, scratch, q);
    gather(model, tree, scratch);
    reduce(model, tree, scratch);
    let n = model.nv;
    let RankBuffers { reduced, share, motion, matrix: m, .. } = scratch;
    let mut least = 1.0_f64;
    for k in (0..n).rev() {
        let pivot = m[k * n + k];
        let left = pivot / (reduced[k] * reduced[k]);
        if !is_clear(left, least, bound) {
            // z: row j of L z is zero for each j beyond k.
            motion[k] = 1.0;
            share[k] = reduced[k];
            for j in k + 1..n {
                let row = &m[j * n..(j + 1) * n];
                motion[j] = -(k..j).map(|i| row[i] * motion[i]).sum::<f64>();
                share[j] = motion[j].abs() * reduced[j];
            }
            if vanishes(pivot, bound, share[k..n].iter().sum()) {
                let inertia = reduced[k] * reduced[k];
                on_vanished(&VanishedPivot { index: k, pivot, inertia, share: &share[k..n] });
                // The DoF is locked: the elimination leaves it out.
                m[k * n..k * n + k].fill(0.0);
                continue;
            }
        }
        least = least.min(left);
        eliminate_row(m, n, k);
    }
}

/// Eliminates row k from the rows before it, and divides it by its pivot: row k of L.
fn eliminate_row(m: &mut [f64], n: usize, k: usize) {
    let pivot = m[k * n + k];
    for i in 0..k {
        let ratio = m[k * n + i] / pivot;
        for j in 0..=i {
            m[i * n + j] -= ratio * m[k * n + j];
        }
    }
    for i in 0..k {
        m[k * n + i] /= pivot;
    }
}

/// The inertia of each body's subtree as one rigid body, and √N of each DoF.
fn gather(model: &Model, tree: &mut TreeMemory<f64>, scratch: &mut RankBuffers) {
    scratch.extent.copy_from_slice(&scratch.own);
    for (i, body) in model.bodies.iter().enumerate().rev() {
        for index in body.dof..body.dof + body.motion.nv() {
            let armature = model.dofs[index].passive.armature;
            let size = scratch.extent[i].along(body.motion, index - body.dof) + armature;
            scratch.root[index] = size.sqrt();
        }
        if body.parent != WORLD {
            let child = tree.inertias.articulated[i];
            let p = tree.world.pose[i].translation;
            add_shifted(&mut tree.inertias.articulated[body.parent], &child, p);
            let extent = scratch.extent[i];
            scratch.extent[body.parent].add(&extent, scratch.distance[i]);
        }
    }
}

/// The lower triangle of M_y and √N of each coordinate. M_ij = Sᵢᵀ I^c_j Sⱼ, with the force propagated
/// towards the root. **(RBDA §6.2)**
fn reduce(model: &Model, tree: &mut TreeMemory<f64>, scratch: &mut RankBuffers) {
    let n = model.nv;
    scratch.matrix.fill(0.0);
    scratch.reduced.fill(0.0);
    for (j, dof) in model.dofs.iter().enumerate() {
        scratch.reduced[dof.coordinate] += dof.ratio.abs() * scratch.root[j];
        let mut force: ForceVector<f64> =
            response(&tree.inertias.articulated[dof.body], &tree.world.column[j]);
        let (mut at, mut last) = (dof.body, j);
        loop {
            let body = &model.bodies[at];
            for i in body.dof..=last {
                let other = &model.dofs[i];
                let mut entry = tree.world.column[i].dot(&force) * dof.ratio * other.ratio;
                if i == j {
                    entry += dof.passive.armature * dof.ratio * dof.ratio;
                } else if other.coordinate == dof.coordinate {
                    // M_ij and M_ji.
                    entry *= 2.0;
                }
                let (row, column) =
                    (dof.coordinate.max(other.coordinate), dof.coordinate.min(other.coordinate));
                scratch.matrix[row * n + column] += entry;
            }
            if body.parent == WORLD {
                break;
            }
            force.angular += tree.world.pose[at].translation.cross(force.linear);
            at = body.parent;
            last = model.bodies[at].dof + model.bodies[at].motion.nv() - 1;
        }
    }
    for rotor in &model.rotors {
        for (coordinate, root) in rotor.roots(&model.dofs) {
            scratch.reduced[coordinate] += root;
        }
        for (row, column, entry) in rotor.entries(&model.dofs).filter(|(row, column, _)| column <= row) {
            scratch.matrix[row * n + column] += entry;
        }
    }
}
