//! Two computations of the acceleration.

use robot_dynamics_core::{Workspace, forward_dynamics, forward_dynamics_by_cholesky};

use super::check::{Check, LargestDefect};
use super::probe::{Probe, worst_entry};
use crate::lagrange;

/// The articulated-body algorithm against Cholesky factorization. If mimic joints or tendons' armature couple
/// branches, both functions use Cholesky, and the second computation is the Lagrange recipe.
pub(super) fn two_routes(probe: &Probe<'_>) -> Check {
    let (model, reference) = (probe.model, probe.reference);
    let law = if model.needs_dense_factor {
        "a by the composite bodies' M = a by the Lagrange recipe"
    } else {
        "a by articulated bodies = a by Cholesky"
    };
    let mut worst = LargestDefect::of("forward_routes", law);
    let (workspace, other_workspace) = (&mut Workspace::new(model), &mut Workspace::new(reference));
    let (mut a, mut other) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    for (index, state) in probe.states() {
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        forward_dynamics(model, workspace, q, v, tau, &mut a);
        if model.needs_dense_factor {
            other = lagrange::forward_dynamics(reference, q, v, tau);
        } else {
            forward_dynamics_by_cholesky(reference, other_workspace, q, v, tau, &mut other);
        }
        let (found, allowed) = worst_entry(&a, &other, &state.acceleration_errors(&a));
        worst.record(found, allowed, index);
    }
    worst.check()
}
