//! The recursions against the Lagrange recipe and against each other, on hundreds of random robots.
//!
//! Tolerances. Identities without an inverse add up terms along paths of at most 60 joints; 1e-12 of the
//! largest entry of the quantity allows 4500 roundings. Where M is inverted, κ(M) ε times a modest count.

mod common;

use common::{Robot, dot, families, max_difference, size, times};
use multibody::{Workspace, lagrange};

const ROUNDING: f64 = 1e-12;

/// M, K and V of the recursions are those of the Lagrange recipe, and ½ vᵀM v = K.
#[test]
fn energies_match_lagrange() {
    for robot in families().iter().flat_map(|family| family.robots()) {
        let Robot { model, state, .. } = &robot;
        let (q, v) = (&state.q[..], &state.v[..]);
        let w = &mut Workspace::new(model);
        let (mass, oracle) = (robot.mass(), lagrange::mass_matrix(model, q));
        robot.require("M = Σ m J_cᵀJ_c + J_ωᵀ𝓘J_ω", max_difference(&mass, &oracle), ROUNDING * size(&oracle));

        let kinetic = lagrange::kinetic_energy(model, q, v);
        let scale = size(&oracle) * dot(v, v);
        let defect = (multibody::kinetic_energy(model, w, q, v) - kinetic).abs();
        robot.require("K", defect, ROUNDING * scale);
        robot.require("K = ½ vᵀM v", (0.5 * dot(v, &times(&mass, v)) - kinetic).abs(), ROUNDING * scale);

        let potential = lagrange::potential_energy(model, q);
        let defect = (multibody::potential_energy(model, w, q) - potential).abs();
        // V is a sum of terms of either sign; m |g| |c| with |c| of a few metres bounds it.
        let scale = potential.abs() + model.mass() * 9.81;
        robot.require("V", defect, ROUNDING * scale);
    }
}

/// C v, g, C v + g and τ of the recursions are those of exact derivatives of the energies.
#[test]
fn forces_match_lagrange() {
    for robot in families().iter().flat_map(|family| family.robots()) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a) = (&state.q[..], &state.v[..], &state.a[..]);
        let w = &mut Workspace::new(model);
        let mut found = vec![0.0; model.nv()];

        let product = lagrange::velocity_product(model, q, v);
        // Each term of C v is an inertia times two velocities.
        let product_scale = size(&robot.mass()) * dot(v, v);
        multibody::velocity_product(model, w, q, v, &mut found);
        robot.require("C v", max_difference(&found, &product), ROUNDING * product_scale);

        let gravity = lagrange::gravity(model, q);
        // A force of m |g| on an arm of a metre.
        let gravity_scale = size(&gravity) + model.mass() * 9.81;
        multibody::gravity(model, w, q, &mut found);
        robot.require("g = ∂V/∂q", max_difference(&found, &gravity), ROUNDING * gravity_scale);

        let scale = product_scale + gravity_scale;
        let bias = lagrange::bias(model, q, v);
        multibody::bias(model, w, q, v, &mut found);
        robot.require("C v + g", max_difference(&found, &bias), ROUNDING * scale);

        let tau = lagrange::inverse_dynamics(model, q, v, a);
        multibody::inverse_dynamics(model, w, q, v, a, &mut found);
        let scale = scale + size(&robot.mass()) * dot(a, a).sqrt();
        robot.require("τ", max_difference(&found, &tau), ROUNDING * scale);
    }
}
