//! Every row of the table of integrators: its order, its symmetry, its energy.

use std::f64::consts::PI;

use dynamics::{Integrator, Reach2R, energy_drift};
use nalgebra::{Vector2, vector};

/// The worked example: τ = 0, h = 1 ms, 10 s from rest at (π/4, π/2).
#[test]
fn energy_drift_rk4() {
    let arm = Reach2R::worked_example();
    let drift = |integrator| {
        let (q0, zero) = (vector![PI / 4.0, PI / 2.0], Vector2::zeros());
        energy_drift(&arm, &q0, &zero, &zero, 1e-3, 10_000, integrator).unwrap()
    };
    let (rk4, semi, explicit) = (
        drift(Integrator::RungeKutta4),
        drift(Integrator::SemiImplicitEuler),
        drift(Integrator::ExplicitEuler),
    );
    println!("rk4 {rk4:.2e}   semi-implicit Euler {semi:.2e}   explicit Euler {explicit:.2e}");
    assert!(rk4 < 1e-6, "{rk4:e}");
    assert!(explicit > 1e-3, "{explicit:e}");
    // 1.22e-8, by two independent computations of the same definition.
    assert!((rk4 - 1.22e-8).abs() < 0.01e-8, "{rk4:e}");
}
