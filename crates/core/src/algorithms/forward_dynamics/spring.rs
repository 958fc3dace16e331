//! Springs of the joints.

use robot_dynamics_number::Scalar;

use crate::Model;

/// A DoF's force less its spring's.
#[inline(always)]
pub(super) fn less_spring<S: Scalar>(model: &Model, dof: usize, force: S, position: S) -> S {
    if !model.has_springs {
        return force;
    }
    let passive = &model.dofs[dof].passive;
    force - (position - S::from_f64(passive.rest)).scale(passive.stiffness)
}
