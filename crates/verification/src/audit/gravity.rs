//! Gravity as the gradient of the potential energy that `dynamics simulate` prints.

use robot_dynamics_core::{Workspace, potential_energy};
use robot_dynamics_number::Dual;

use super::check::{Check, LargestDefect};
use super::probe::{Probe, ROUNDING, difference, largest};
use crate::lagrange;

/// g of the Newton–Euler recursion = ∂V/∂q of the sum over the bodies, by dual numbers.
pub(super) fn gradient_of_potential(probe: &Probe<'_>) -> Check {
    let mut worst = LargestDefect::of("gravity", "g = ∂V/∂q along each coordinate");
    let (model, reference, nv) = (probe.model, probe.reference, probe.model.nv());
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(reference);
    let mut gravity = vec![0.0; nv];
    for (index, state) in probe.states() {
        robot_dynamics_core::gravity(model, workspace, &state.q, &mut gravity);
        let slope = |k: usize| {
            let mut unit = vec![0.0; nv];
            unit[k] = 1.0;
            let rates = lagrange::position_rate(model, &state.q, &unit);
            let moving = state.q.iter().zip(rates).map(|(&value, rate)| Dual { value, gradient: [rate] });
            potential_energy(reference, duals, &moving.collect::<Vec<_>>()).gradient[0]
        };
        let derivatives: Vec<f64> = (0..nv).map(slope).collect();
        worst.record(
            difference(&gravity, &derivatives),
            ROUNDING * (probe.weight + largest(&gravity)),
            index,
        );
    }
    worst.check()
}
