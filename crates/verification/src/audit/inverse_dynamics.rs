//! Forward and inverse dynamics are inverse functions.

use robot_dynamics_core::{Workspace, forward_dynamics, inverse_dynamics};

use super::check::{Check, LargestDefect};
use super::probe::{Probe, worst_entry};

/// a → τ by the Newton–Euler recursion → a by forward dynamics.
pub(super) fn undoes_forward(probe: &Probe<'_>) -> Check {
    let mut worst = LargestDefect::of("forward_inverse", "forward dynamics of (inverse dynamics of a) = a");
    let (model, reference) = (probe.model, probe.reference);
    let (workspace, other_workspace) = (&mut Workspace::new(model), &mut Workspace::new(reference));
    let (mut tau, mut a) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    for (index, state) in probe.states() {
        inverse_dynamics(reference, other_workspace, &state.q, &state.v, &state.a, &mut tau);
        forward_dynamics(model, workspace, &state.q, &state.v, &tau, &mut a);
        let (found, allowed) = worst_entry(&a, &state.a, &state.acceleration_errors(&state.a));
        worst.record(found, allowed, index);
    }
    worst.check()
}
