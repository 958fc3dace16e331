//! Where the motors' power goes.

use dynamics::Dual;
use multibody::{Workspace, forward_dynamics, kinetic_energy, lagrange, potential_energy};

use super::check::{Check, Worst};
use super::probe::{Probe, ROUNDING, dot};

/// d/dt (K + V) = τ·v along the motion that τ causes, by dual numbers.
pub(crate) fn balance(probe: &Probe<'_>) -> Check {
    let mut worst = Worst::of("power", "d/dt (K + V) = τ·v");
    let model = probe.model;
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(model);
    let mut a = vec![0.0; model.nv()];
    let moving = |at: &[f64], rate: &[f64]| -> Vec<Dual<f64, 1>> {
        at.iter().zip(rate).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect()
    };
    for (index, state) in probe.states() {
        forward_dynamics(model, workspace, &state.q, &state.v, &state.tau, &mut a);
        let q = moving(&state.q, &lagrange::position_rate(model, &state.q, &state.v));
        let v = moving(&state.v, &a);
        let energy = kinetic_energy(model, duals, &q, &v) + potential_energy(model, duals, &q);
        // What the error of a does to K̇ is vᵀM times it.
        let allowed = state.speed * (state.inertia * state.acceleration_error(&a) + ROUNDING * state.force);
        worst.see((energy.gradient[0] - dot(&state.v, &state.tau)).abs(), allowed, index);
    }
    worst.check()
}
