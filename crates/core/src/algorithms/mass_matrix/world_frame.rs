//! The composite-rigid-body algorithm in one inertial frame ([`world_frame`](crate::kinematics::world_frame)).
//!
//! No vector is rotated on the way. The columns of a subtree are contiguous: a row of M is the sum of six
//! products of a number with a contiguous array. **(RBDA §6.2)**

use robot_dynamics_number::Scalar;

use super::columns::{project_column, project_columns, write_column};
use super::entries::{Entries, add_armature, add_reduced, armature};
use crate::Model;
use crate::kinematics::shifts::pass_inward;
use crate::kinematics::world_frame::{composites_in_world, compute_columns, momentum_of};
use crate::model::WORLD;
use crate::workspace::tree::TreeMemory;

/// Writes the selected entries of M.
#[inline(always)]
pub(super) fn write_matrix<N: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    mass: &mut [N],
    entries: Entries,
) {
    compute_columns(model, tree, q);
    composites_in_world(model, tree);
    if model.points.carried {
        write_from_point_to_point(model, tree, mass);
        add_armature(model, mass);
        return;
    }
    let (nv, dofs) = (model.nv, model.dofs.len());
    let (composites, columns) = (&tree.inertias.composite[..], &tree.world.column[..dofs]);
    let rows = &mut tree.blocks.rows[..];
    for (index, dof) in model.dofs.iter().enumerate() {
        write_column(rows, dofs, index, &momentum_of(&composites[dof.body], &columns[index]));
    }
    if entries == Entries::All || model.needs_dense_factor {
        mass.fill(N::zero());
    }
    if model.needs_dense_factor {
        for (i, dof) in model.dofs.iter().enumerate() {
            for j in i..dof.end {
                add_reduced(model, mass, i, j, project_column(rows, dofs, j, &columns[i]));
            }
        }
    } else {
        let mut packed = 0;
        for (i, dof) in model.dofs.iter().enumerate() {
            let start = if entries == Entries::Packed { packed } else { i * (nv + 1) };
            packed += dof.end - i;
            let (row, below) = mass[start..].split_at_mut(dof.end - i);
            project_columns(rows, dofs, i..dof.end, &columns[i], row);
            if entries == Entries::Packed {
                if model.has_armature {
                    row[0] += N::from_f64(armature(dof));
                }
            } else if entries != Entries::RelatedAbove {
                for (mirror, &entry) in below[nv - dof.end..].chunks_exact_mut(nv).zip(&row[1..]) {
                    mirror[i] = entry;
                }
            }
        }
        if entries == Entries::Packed {
            return;
        }
    }
    add_armature(model, mass);
}

/// All entries: projects each DoF's momentum on its ancestors, moving the reference point from body to body.
#[inline(always)]
fn write_from_point_to_point<N: Scalar>(model: &Model, tree: &TreeMemory<N>, mass: &mut [N]) {
    mass.fill(N::zero());
    for (j, dof) in model.dofs.iter().enumerate() {
        let mut momentum = momentum_of(&tree.inertias.composite[dof.body], &tree.world.column[j]);
        let mut at = dof.body;
        while at != WORLD {
            let body = &model.bodies[at];
            for i in body.dof..(body.dof + body.motion.nv()).min(j + 1) {
                add_reduced(model, mass, i, j, tree.world.column[i].dot(&momentum));
            }
            pass_inward(body, &tree.world.levers, &mut momentum);
            at = body.parent;
        }
    }
}
