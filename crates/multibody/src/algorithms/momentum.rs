//! The derivatives of the kinetic energy: generalized momentum, and the change with the coordinates.

use dynamics::Scalar;

use crate::model::WORLD;
use crate::model::length::check_length;
use crate::spatial::screw::Force;
use crate::stages::place::gather;
use crate::stages::screws::{inertia_in_world, momentum_of, motion_cross, move_screws, place_screws};
use crate::stages::shifts::{pass_inward, pass_outward};
use crate::{Model, Workspace};

/// p = ∂K/∂v = M(q) v, without forming M: each freedom's share of the momentum beyond it, O(n).
///
/// Units are N·s or N·m·s. Armature counts in it.
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn momentum<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    momentum: &mut [S],
) {
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the momentum", momentum.len(), model.nv);
    collect_momenta(model, workspace, q, v);
    for (index, dof) in model.dofs.iter().enumerate() {
        let rotor = workspace.v[index].scale(dof.passive.armature);
        workspace.tau[index] = workspace.column[index].dot(&workspace.force[dof.body]) + rotor;
    }
    gather(model, &workspace.tau, momentum);
}

/// ∂K/∂q with v held, N or N·m: Hamel's equations read ṗ = τ + ∂K/∂q − ∂V/∂q where q is plain numbers.
///
/// For a quaternion joint, entry k is the rate of K when the joint moves by the unit velocity eₖ of v while
/// every component of v keeps its value.
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn kinetic_energy_gradient<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    gradient: &mut [S],
) {
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the gradient", gradient.len(), model.nv);
    collect_momenta(model, workspace, q, v);
    for (index, dof) in model.dofs.iter().enumerate() {
        let parent = model.bodies[dof.body].parent;
        // Turning everything beyond the freedom by S turns its velocities along, but not the velocity V that
        // the parent gives it: seen from the turned bodies, V changes by V × S.
        let mut carried = if parent == WORLD { Force::zero() } else { workspace.twist[parent] };
        pass_outward(&model.bodies[dof.body], &workspace.levers, &mut carried);
        let change = motion_cross(&carried, &workspace.column[index]);
        workspace.tau[index] = change.dot(&workspace.force[dof.body]);
    }
    gather(model, &workspace.tau, gradient);
}

/// Σ I V over each body and all that hangs on it, to `workspace.force`.
#[inline(always)]
fn collect_momenta<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], v: &[S]) {
    place_screws(model, workspace, q);
    move_screws(model, workspace, v);
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &workspace.world[i]);
        workspace.force[i] = momentum_of(&inertia, &workspace.twist[i]);
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD {
            let mut beyond = workspace.force[i];
            pass_inward(body, &workspace.levers, &mut beyond);
            workspace.force[body.parent].add(&beyond);
        }
    }
}
