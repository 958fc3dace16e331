//! The recursions against the Lagrange recipe, which sees the links as the file names them.

use crate::{Workspace, lagrange};

use super::check::{Check, Worst};
use super::probe::{Probe, ROUNDING, difference, largest};

/// M, C v and g by the recursions and by exact derivatives of K and V.
pub(super) fn checks(probe: &Probe<'_>) -> [Check; 3] {
    let (model, oracle) = (probe.model, probe.oracle);
    let workspace = &mut Workspace::new(model);
    let mut found = vec![0.0; model.nv()];
    let mut mass = Worst::of("lagrange_mass", "M = Σ (m J_cᵀJ_c + J_ωᵀ𝓘J_ω)");
    let mut product = Worst::of("lagrange_velocity_product", "C v of the recursion = that of ∂M/∂q");
    let mut gravity = Worst::of("lagrange_gravity", "g of the recursion = ∂V/∂q of the recipe");
    for (index, state) in probe.states() {
        let (q, v) = (&state.q[..], &state.v[..]);
        mass.see(difference(&state.mass, &lagrange::mass_matrix(oracle, q)), ROUNDING * state.inertia, index);
        crate::velocity_product(model, workspace, q, v, &mut found);
        let defect = difference(&found, &lagrange::velocity_product(oracle, q, v));
        product.see(defect, ROUNDING * state.inertia * state.speed * state.speed, index);
        crate::gravity(model, workspace, q, &mut found);
        let defect = difference(&found, &lagrange::gravity(oracle, q));
        gravity.see(defect, ROUNDING * (probe.weight + largest(&found)), index);
    }
    [mass.check(), product.check(), gravity.check()]
}
