//! Gravity as the slope of the potential energy that `dynamics simulate` prints.

use crate::{Workspace, lagrange, potential_energy};
use dynamics::Dual;

use super::check::{Check, Worst};
use super::probe::{Probe, ROUNDING, difference, largest};

/// g of the Newton–Euler recursion = ∂V/∂q of the sum over the bodies, by dual numbers.
pub(super) fn slope_of_potential(probe: &Probe<'_>) -> Check {
    let mut worst = Worst::of("gravity", "g = ∂V/∂q along each coordinate");
    let (model, oracle, nv) = (probe.model, probe.oracle, probe.model.nv());
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(oracle);
    let mut gravity = vec![0.0; nv];
    for (index, state) in probe.states() {
        crate::gravity(model, workspace, &state.q, &mut gravity);
        let slope = |k: usize| {
            let mut unit = vec![0.0; nv];
            unit[k] = 1.0;
            let rates = lagrange::position_rate(model, &state.q, &unit);
            let moving = state.q.iter().zip(rates).map(|(&value, rate)| Dual { value, gradient: [rate] });
            potential_energy(oracle, duals, &moving.collect::<Vec<_>>()).gradient[0]
        };
        let slopes: Vec<f64> = (0..nv).map(slope).collect();
        worst.see(difference(&gravity, &slopes), ROUNDING * (probe.weight + largest(&gravity)), index);
    }
    worst.check()
}
