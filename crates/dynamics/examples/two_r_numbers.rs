//! Every number of the worked example: the two-link arm at q = (π/4, π/2), in Earth gravity.
//!
//! The drift in the last line is max |E − E₀|/|E₀| over the 10 000 steps, from rest at that pose with no
//! torque; E₀ = V there, with V = 0 at the height of the first joint.
//!
//! `cargo run --example two_r_numbers -p dynamics`

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::fmt::Write;

use dynamics::{Dynamics, Integrator, Reach2R, energy_drift};
use nalgebra::{Vector2, vector};

fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", numbers()?);
    Ok(())
}

/// The table, computed.
///
/// # Errors
/// Where the arm cannot be integrated; this one can.
pub fn numbers() -> Result<String, Box<dyn Error>> {
    let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81);
    let q = vector![FRAC_PI_4, FRAC_PI_2];
    let qd = vector![1.0, 0.0];
    let mut text = String::new();

    let m = arm.mass(&q);
    let eigenvalues = m.symmetric_eigenvalues();
    write!(text, "M   = [[{:.4}, {:.4}], [{:.4}, {:.4}]]", m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)])?;
    writeln!(
        text,
        "      det {:.4}   eig {:.4} {:.4}",
        m.determinant(),
        eigenvalues.max(),
        eigenvalues.min()
    )?;

    let g = arm.gravity(&q);
    writeln!(text, "g   = [{:.4}, {:.4}]", g[0], g[1])?;
    let product = arm.velocity_product(&q, &qd);
    // Adding zero turns −0 into 0.
    writeln!(text, "Cq̇  = [{:.4}, {:.4}]        for q̇ = (1, 0)", product[0] + 0.0, product[1])?;
    let (kinetic, potential) = (arm.kinetic_energy(&q, &qd), arm.potential_energy(&q));
    writeln!(text, "K   = {kinetic:.4} J    V = {potential:.4} J    E = {:.4} J", arm.energy(&q, &qd))?;

    let [open, bent, folded] = [0.0, FRAC_PI_2, PI].map(|q2| arm.mass(&vector![q[0], q2])[(0, 0)]);
    writeln!(text, "M11 sweep over q2 ∈ {{0, π/2, π}}:  {open:.4}  {bent:.4}  {folded:.4}")?;

    let rest = Vector2::zeros();
    let drift = |integrator| energy_drift(&arm, &q, &rest, &rest, 1e-3, 10_000, integrator);
    writeln!(
        text,
        "energy drift, τ = 0, h = 1 ms, 10 s:  rk4 {:.1e}   semi-implicit Euler {:.1e}   explicit Euler {:.1e}",
        drift(Integrator::RungeKutta4)?,
        drift(Integrator::SemiImplicitEuler)?,
        drift(Integrator::ExplicitEuler)?
    )?;
    Ok(text)
}
