//! The worked example: every number of the two-link arm at one pose.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use core::fmt;

use nalgebra::{Matrix2, Vector2, vector};
use robot_dynamics_integrators::{Integrator, IntegratorError};

use crate::{Dynamics, Reach2R, energy_drift};

/// The uniform two-link arm of 1 m, 2 kg and 1 m, 1 kg at q = (π/4, π/2), in Earth gravity. **(PRM 10.7)**
///
/// Its [`Display`](fmt::Display) is the table of the example, every number computed:
///
/// ```
/// let example = dynamics::WorkedExample::compute()?;
/// assert!(example.to_string().starts_with("M   = [[2.0000, 0.3333], [0.3333, 0.3333]]"));
/// assert!(example.drift_rk4 < 1e-6);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkedExample {
    /// M(q) \[kg·m²\].
    pub mass: Matrix2<f64>,
    /// det M.
    pub determinant: f64,
    /// The eigenvalues of M, the larger first \[kg·m²\].
    pub eigenvalues: [f64; 2],
    /// g(q) \[N·m\].
    pub gravity: Vector2<f64>,
    /// C(q,q̇) q̇ at q̇ = (1, 0) \[N·m\].
    pub velocity_product: Vector2<f64>,
    /// K at q̇ = (1, 0) \[J\].
    pub kinetic_energy: f64,
    /// V, zero at the height of the first joint \[J\].
    pub potential_energy: f64,
    /// E = K + V \[J\].
    pub energy: f64,
    /// M₁₁ at q₂ = 0, π/2, π: stretched, bent, folded \[kg·m²\].
    pub m11_sweep: [f64; 3],
    /// max |E − E₀|/|E₀| over 10 s in steps of 1 ms, from rest at q without torque: classical Runge–Kutta.
    pub drift_rk4: f64,
    /// The same for semi-implicit Euler.
    pub drift_semi_implicit_euler: f64,
    /// The same for explicit Euler.
    pub drift_explicit_euler: f64,
}

impl WorkedExample {
    /// Computes every number; the three runs of 10 000 steps take a few milliseconds.
    ///
    /// # Errors
    /// If the integration fails, which does not happen for this arm.
    pub fn compute() -> Result<Self, IntegratorError> {
        let arm = Reach2R::worked_example();
        let (q, qd) = (vector![FRAC_PI_4, FRAC_PI_2], vector![1.0, 0.0]);
        let mass = arm.mass(&q);
        let eigenvalues = mass.symmetric_eigenvalues();
        let rest = Vector2::zeros();
        let drift = |integrator| energy_drift(&arm, &q, &rest, &rest, 1e-3, 10_000, integrator);
        Ok(Self {
            mass,
            determinant: mass.determinant(),
            eigenvalues: [eigenvalues.max(), eigenvalues.min()],
            gravity: arm.gravity(&q),
            velocity_product: arm.velocity_product(&q, &qd),
            kinetic_energy: arm.kinetic_energy(&q, &qd),
            potential_energy: arm.potential_energy(&q),
            energy: arm.energy(&q, &qd),
            m11_sweep: [0.0, FRAC_PI_2, PI].map(|q2| arm.mass(&vector![q[0], q2])[(0, 0)]),
            drift_rk4: drift(Integrator::RungeKutta4)?,
            drift_semi_implicit_euler: drift(Integrator::SemiImplicitEuler)?,
            drift_explicit_euler: drift(Integrator::ExplicitEuler)?,
        })
    }
}

impl fmt::Display for WorkedExample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (m, g, product) = (&self.mass, &self.gravity, &self.velocity_product);
        write!(f, "M   = [[{:.4}, {:.4}], [{:.4}, {:.4}]]", m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)])?;
        let [large, small] = self.eigenvalues;
        writeln!(f, "      det {:.4}   eig {large:.4} {small:.4}", self.determinant)?;
        writeln!(f, "g   = [{:.4}, {:.4}]", g[0], g[1])?;
        // Adding zero changes −0 to 0.
        writeln!(f, "Cq̇  = [{:.4}, {:.4}]        for q̇ = (1, 0)", product[0] + 0.0, product[1])?;
        let (kinetic, potential, energy) = (self.kinetic_energy, self.potential_energy, self.energy);
        writeln!(f, "K   = {kinetic:.4} J    V = {potential:.4} J    E = {energy:.4} J")?;
        let [open, bent, folded] = self.m11_sweep;
        writeln!(f, "M11 sweep over q2 ∈ {{0, π/2, π}}:  {open:.4}  {bent:.4}  {folded:.4}")?;
        writeln!(
            f,
            "energy drift, τ = 0, h = 1 ms, 10 s:  rk4 {:.1e}   semi-implicit Euler {:.1e}   \
             explicit Euler {:.1e}",
            self.drift_rk4, self.drift_semi_implicit_euler, self.drift_explicit_euler
        )
    }
}
