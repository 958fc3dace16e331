//! The recursions against the Lagrange recipe, which uses the links as the file describes them.

use robot_dynamics_core::Workspace;

use super::check::{Check, LargestDefect};
use super::probe::{Probe, ROUNDING, difference, largest};
use crate::lagrange;

/// M, C v and g by the recursions and by exact derivatives of K and V.
pub(super) fn checks(probe: &Probe<'_>) -> [Check; 3] {
    let (model, reference) = (probe.model, probe.reference);
    let workspace = &mut Workspace::new(model);
    let mut found = vec![0.0; model.nv()];
    let mut mass = LargestDefect::of("lagrange_mass", "M = Σ (m J_cᵀJ_c + J_ωᵀ𝓘J_ω)");
    let mut product = LargestDefect::of("lagrange_velocity_product", "C v of the recursion = that of ∂M/∂q");
    let mut gravity = LargestDefect::of("lagrange_gravity", "g of the recursion = ∂V/∂q of the recipe");
    for (index, state) in probe.states() {
        let (q, v) = (&state.q[..], &state.v[..]);
        mass.record(
            difference(&state.mass, &lagrange::mass_matrix(reference, q)),
            ROUNDING * state.inertia,
            index,
        );
        robot_dynamics_core::velocity_product(model, workspace, q, v, &mut found);
        let defect = difference(&found, &lagrange::velocity_product(reference, q, v));
        product.record(defect, ROUNDING * state.inertia * state.speed * state.speed, index);
        robot_dynamics_core::gravity(model, workspace, q, &mut found);
        let defect = difference(&found, &lagrange::gravity(reference, q));
        gravity.record(defect, ROUNDING * (probe.weight + largest(&found)), index);
    }
    [mass.check(), product.check(), gravity.check()]
}
