//! The derivative of the centre of mass's velocity.

use dynamics::Scalar;

use crate::model::WORLD;
use crate::model::length::check_length;
use crate::spatial::screw::Force;
use crate::stages::screws::{inertia_in_world, momentum_of, motion_cross, move_screws, place_screws};
use crate::stages::shifts::{pass_inertia, pass_inward, pass_outward};
use crate::{Model, Workspace};

/// ∂ċ/∂q with v held, 3×nv, row-major, along the world's axes; ∂c/∂q and ∂ċ/∂v are
/// [`center_of_mass_jacobian`](crate::center_of_mass_jacobian).
///
/// Turning all beyond freedom j by S turns its momentum p, and what the parent's velocity V gives it stays
/// behind: m ∂ċ/∂q_j = σ × p + (I (V × S))'s linear part, with p and I of all beyond j. For a quaternion joint,
/// column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass_velocity_derivative<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    by_position: &mut [S],
) {
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    let nv = model.nv;
    check_length("the derivative of the centre of mass's velocity", by_position.len(), 3 * nv);
    place_screws(model, workspace, q);
    move_screws(model, workspace, v);
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &workspace.world[i]);
        workspace.force[i] = momentum_of(&inertia, &workspace.twist[i]);
        workspace.composite[i] = inertia;
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD {
            let (mut force, mut composite) = (workspace.force[i], workspace.composite[i]);
            pass_inward(body, &workspace.levers, &mut force);
            pass_inertia(body, &workspace.levers, &mut composite);
            workspace.force[body.parent].add(&force);
            crate::stages::screws::add_composite(&mut workspace.composite[body.parent], &composite);
        }
    }
    by_position.fill(S::zero());
    let inverse_mass = 1.0 / model.moving_mass();
    for (dof, s) in model.dofs.iter().zip(&workspace.column) {
        let parent = model.bodies[dof.body].parent;
        let mut carrier = if parent == WORLD { Force::zero() } else { workspace.twist[parent] };
        pass_outward(&model.bodies[dof.body], &workspace.levers, &mut carrier);
        let carried = momentum_of(&workspace.composite[dof.body], &motion_cross(&carrier, s)).linear;
        let change = s.angular.cross(workspace.force[dof.body].linear) + carried;
        for (row, entry) in change.array().into_iter().enumerate() {
            by_position[row * nv + dof.coordinate] += entry.scale(dof.ratio * inverse_mass);
        }
    }
}
