//! The mass matrix: positive definite, well conditioned, and consistent with inverse dynamics.

use robot_dynamics_core::Workspace;

use super::check::{Check, LargestDefect};
use super::probe::{Probe, ROUNDING};

/// Above this condition number an acceleration has fewer than four of sixteen digits.
const WORST_CONDITION: f64 = 1e12;

pub(super) fn checks(probe: &Probe<'_>) -> [Check; 2] {
    [condition(probe), columns(probe)]
}

/// M ≻ 0, also in the zero configuration, and κ(M).
fn condition(probe: &Probe<'_>) -> Check {
    let law = "M ≻ 0: κ(M)";
    let singular =
        probe.states().find_map(|(index, state)| Some((format!("state {index}"), state.singular.as_ref()?)));
    let unchecked = if singular.is_some() { "; accelerations are not checked" } else { "" };
    let at_zeros = probe.singular_at_zeros.as_ref().map(|mass| ("all zeros".to_owned(), mass));
    if let Some((place, mass)) = singular.or(at_zeros) {
        let found = (f64::INFINITY, WORST_CONDITION);
        return Check::new("mass_matrix", law, found, format!("{place}: {mass}{unchecked}"));
    }
    let worst = probe.states().max_by(|(_, a), (_, b)| a.condition.total_cmp(&b.condition));
    let (found, place) =
        worst.map_or((0.0, String::new()), |(index, state)| (state.condition, format!("state {index}")));
    Check::new("mass_matrix", law, (found, WORST_CONDITION), place)
}

/// M eⱼ = (τ for acceleration eⱼ at rest) − g: composite bodies against the Newton–Euler recursion.
fn columns(probe: &Probe<'_>) -> Check {
    let mut worst = LargestDefect::of("mass_columns", "M eⱼ = inverse dynamics of eⱼ at rest");
    let (reference, nv) = (probe.reference, probe.model.nv());
    let workspace = &mut Workspace::new(reference);
    let rest = vec![0.0; nv];
    let (mut weight, mut column) = (rest.clone(), rest.clone());
    for (index, state) in probe.states() {
        robot_dynamics_core::inverse_dynamics(reference, workspace, &state.q, &rest, &rest, &mut weight);
        for j in 0..nv {
            let mut unit = rest.clone();
            unit[j] = 1.0;
            robot_dynamics_core::inverse_dynamics(reference, workspace, &state.q, &rest, &unit, &mut column);
            for i in 0..nv {
                let defect = (column[i] - weight[i] - state.mass[i * nv + j]).abs();
                worst.record(defect, ROUNDING * (state.inertia + probe.weight + weight[i].abs()), index);
            }
        }
    }
    worst.check()
}
