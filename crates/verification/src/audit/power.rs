//! The power balance.

use robot_dynamics_core::{Workspace, forward_dynamics, kinetic_energy, potential_energy};
use robot_dynamics_number::Dual;

use super::check::{Check, LargestDefect};
use super::probe::{Probe, dot};
use crate::lagrange;

/// d/dt (K + V) = τ·v along the motion that τ causes, by dual numbers.
pub(super) fn balance(probe: &Probe<'_>) -> Check {
    let mut worst = LargestDefect::of("power", "d/dt (K + V) = τ·v");
    let (model, reference) = (probe.model, probe.reference);
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(reference);
    let mut a = vec![0.0; model.nv()];
    let moving = |at: &[f64], rate: &[f64]| -> Vec<Dual<f64, 1>> {
        at.iter().zip(rate).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect()
    };
    for (index, state) in probe.states() {
        forward_dynamics(model, workspace, &state.q, &state.v, &state.tau, &mut a);
        let q = moving(&state.q, &lagrange::position_rate(model, &state.q, &state.v));
        let v = moving(&state.v, &a);
        let energy = kinetic_energy(reference, duals, &q, &v) + potential_energy(reference, duals, &q);
        let defect = (energy.gradient[0] - dot(&state.v, &state.tau)).abs();
        worst.record(defect, state.power_error(&a), index);
    }
    worst.check()
}
