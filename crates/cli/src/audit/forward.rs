//! Two ways to solve for the acceleration.

use multibody::{Workspace, forward_dynamics, forward_dynamics_by_cholesky, lagrange};

use super::check::{Check, Worst};
use super::probe::{Probe, difference};

/// Articulated bodies = Cholesky; where joints follow others both are Cholesky, and the Lagrange recipe is
/// the second route.
pub(crate) fn two_routes(probe: &Probe<'_>) -> Check {
    let model = probe.model;
    let law = if model.has_mimic() {
        "a by the composite bodies' M = a by the Lagrange recipe"
    } else {
        "a by articulated bodies = a by Cholesky"
    };
    let mut worst = Worst::of("forward_routes", law);
    let workspace = &mut Workspace::new(model);
    let (mut a, mut other) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    for (index, state) in probe.states() {
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        forward_dynamics(model, workspace, q, v, tau, &mut a);
        if model.has_mimic() {
            other = lagrange::forward_dynamics(model, q, v, tau);
        } else {
            forward_dynamics_by_cholesky(model, workspace, q, v, tau, &mut other);
        }
        worst.see(difference(&a, &other), state.acceleration_error(&a), index);
    }
    worst.check()
}
