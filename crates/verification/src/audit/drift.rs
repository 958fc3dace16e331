//! The energy drift of a free motion with every integrator.

use robot_dynamics_integrators::Integrator;
use robot_dynamics_simulation::simulator::{Effect, Method, RunOptions, SimulationBuilder};

use super::check::Check;
use super::probe::{Probe, State};

/// The duration of a run \[s\].
const DURATION: f64 = 0.2;

/// The first step \[s\], and the number of times it may be halved for a robot with fast motions.
const FIRST_STEP: f64 = 4e-3;
const HALVINGS: u32 = 8;

/// Halving the step must divide the drift by 2ᵖ, with a factor of √2 for terms of higher order.
const SLACK: f64 = std::f64::consts::SQRT_2;

/// One check for each row of the table of integrators, from the first state. A motion without motors, damping
/// and friction conserves E. The drift max |E − E₀| is therefore an error of the integrator and decreases
/// with its order. With wrong forces the drift does not decrease with the step.
pub(super) fn checks(probe: &Probe<'_>) -> Vec<Check> {
    Integrator::ALL.into_iter().filter_map(|row| Some(check(probe, probe.states.first()?, row))).collect()
}

fn check(probe: &Probe<'_>, state: &State, integrator: Integrator) -> Check {
    let order = integrator.order();
    // The magnitude of the terms of E; each step rounds it.
    let energy = probe.weight + state.inertia * state.speed * state.speed;
    let mut step = FIRST_STEP;
    let mut coarse = drift(probe, state, integrator, step);
    let mut halvings = 0;
    loop {
        let fine = drift(probe, state, integrator, step / 2.0);
        let rounding = f64::EPSILON * energy * 2.0 * DURATION / step;
        let allowed = allowed(order, coarse, rounding);
        halvings += 1;
        if fine <= allowed || halvings > HALVINGS {
            let law = format!("energy drift by {integrator} (order {order}) [J]");
            let place = format!(
                "{DURATION} s, step {} → {} ms, drift there {coarse:.1e}",
                milliseconds(step),
                milliseconds(step / 2.0)
            );
            return Check::new(name(integrator), law, (fine, allowed), place);
        }
        step /= 2.0;
        coarse = fine;
    }
}

/// The allowed drift after halving a step with the drift `coarse`: 2⁻ᵖ of it, or rounding. A failed run has
/// no drift to compare.
fn allowed(order: u32, coarse: f64, rounding: f64) -> f64 {
    let shrunk = SLACK / 2f64.powi(order.cast_signed()) * coarse;
    if coarse.is_finite() { shrunk.max(rounding) } else { rounding }
}

fn name(integrator: Integrator) -> String {
    format!("drift_{}", integrator.name().replace('-', "_"))
}

/// In ms, without trailing zeros.
fn milliseconds(step: f64) -> String {
    let text = format!("{:.6}", 1e3 * step);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// max |E − E₀| \[J\]; infinite if the run fails.
fn drift(probe: &Probe<'_>, state: &State, integrator: Integrator, step: f64) -> f64 {
    let free = SimulationBuilder::new(probe.model).method(Method::Fixed(integrator)).conservative();
    let tree = free.without(Effect::Equalities).without(Effect::Springs);
    let Ok(mut simulation) = tree.dt(step).build() else { return f64::INFINITY };
    // At most 0.2 s / 7 µs.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (DURATION / step).round() as usize;
    let run = simulation.run_steps_from(&state.q, &state.v, steps, RunOptions::new().sample_ends());
    run.map_or(f64::INFINITY, |run| run.energy_account.max_imbalance())
}

#[cfg(test)]
mod tests {
    use super::allowed;

    /// A drift that decreases with the integrator's order passes. A constant drift, as from wrong forces, or
    /// one of lower order, fails.
    #[test]
    fn the_order_is_asked_for() {
        for order in [1_u32, 2, 4] {
            let halved = 2f64.powi(-i32::try_from(order).unwrap());
            assert!(halved * 1e-3 <= allowed(order, 1e-3, 1e-12));
            assert!(1e-3 > allowed(order, 1e-3, 1e-12), "{order}");
            assert!(order == 1 || 2.0 * halved * 1e-3 > allowed(order, 1e-3, 1e-12), "{order}");
            assert_eq!(allowed(order, f64::INFINITY, 1e-12), 1e-12);
        }
    }
}
