//! The forces of a step, and the acceleration under them.

use robot_dynamics_core::{Model, Workspace, dissipation, forward_dynamics};
use robot_dynamics_integrators::{IntegratorError, check_computed};
use robot_dynamics_number::Scalar;

/// The forces on the joints during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepForces<'a, S = f64> {
    /// Generalized forces τ of the motors, constant over the step, nv entries \[N·m or N\].
    pub tau: &'a [S],
    /// Whether the joints' damping and friction act. Springs and armature always act.
    ///
    /// Damping uses the velocity of every evaluation. So does the sign of the Coulomb friction, except in the
    /// implicit rows, which use the sign at the start of the step.
    pub dissipation: bool,
}

impl<'a, S> StepForces<'a, S> {
    /// Creates forces with τ constant over the step, with or without damping and friction.
    pub const fn new(tau: &'a [S], dissipation: bool) -> Self {
        Self { tau, dissipation }
    }
}

/// a = M⁻¹(τ − b(v) − C v − g) at the state (q, v); writes τ − b(v) to `force`.
pub fn accelerate(
    model: &Model,
    workspace: &mut Workspace,
    forces: &StepForces<'_>,
    force: &mut [f64],
    (q, v): (&[f64], &[f64]),
    acceleration: &mut [f64],
) -> Result<(), IntegratorError> {
    net_force(model, forces, v, force);
    forward_dynamics(model, workspace, q, v, force, acceleration);
    check_computed("the acceleration", acceleration)
}

/// τ − b(v).
pub fn net_force<S: Scalar>(model: &Model, forces: &StepForces<'_, S>, v: &[S], force: &mut [S]) {
    if forces.dissipation {
        dissipation(model, v, force);
        force.iter_mut().zip(forces.tau).for_each(|(b, tau)| *b = *tau - *b);
    } else {
        force.copy_from_slice(forces.tau);
    }
}
