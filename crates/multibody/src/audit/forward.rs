//! Two ways to solve for the acceleration.

use crate::{Workspace, forward_dynamics, forward_dynamics_by_cholesky, lagrange};

use super::check::{Check, Worst};
use super::probe::{Probe, worst_entry};

/// Articulated bodies = Cholesky; where branches are coupled, by followers or by tendons' armature, both are Cholesky, and the
/// Lagrange recipe is the second route.
pub(super) fn two_routes(probe: &Probe<'_>) -> Check {
    let (model, oracle) = (probe.model, probe.oracle);
    let law = if model.couples_branches {
        "a by the composite bodies' M = a by the Lagrange recipe"
    } else {
        "a by articulated bodies = a by Cholesky"
    };
    let mut worst = Worst::of("forward_routes", law);
    let (workspace, other_workspace) = (&mut Workspace::new(model), &mut Workspace::new(oracle));
    let (mut a, mut other) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    for (index, state) in probe.states() {
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        forward_dynamics(model, workspace, q, v, tau, &mut a);
        if model.couples_branches {
            other = lagrange::forward_dynamics(oracle, q, v, tau);
        } else {
            forward_dynamics_by_cholesky(oracle, other_workspace, q, v, tau, &mut other);
        }
        let (found, allowed) = worst_entry(&a, &other, &state.acceleration_errors(&a));
        worst.see(found, allowed, index);
    }
    worst.check()
}
