//! The two-link arm of the lab, with joint friction and an optional error: C q̇ can be left out.

use dynamics::{Dynamics, Reach2R};
use nalgebra::{Matrix2, Vector2};

/// M q̈ + C q̇ + g + b = u with b = d q̇ in both joints. Without C q̇ the energy drifts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LabArm {
    pub(crate) arm: Reach2R,
    /// d \[N·m·s/rad\].
    pub(crate) damping: f64,
    pub(crate) has_coriolis: bool,
}

impl Dynamics<2> for LabArm {
    fn mass(&self, q: &Vector2<f64>) -> Matrix2<f64> {
        self.arm.mass(q)
    }

    fn velocity_product(&self, q: &Vector2<f64>, qd: &Vector2<f64>) -> Vector2<f64> {
        if self.has_coriolis { self.arm.velocity_product(q, qd) } else { Vector2::zeros() }
    }

    fn gravity(&self, q: &Vector2<f64>) -> Vector2<f64> {
        self.arm.gravity(q)
    }

    fn potential_energy(&self, q: &Vector2<f64>) -> f64 {
        self.arm.potential_energy(q)
    }

    fn dissipation(&self, _: &Vector2<f64>, qd: &Vector2<f64>) -> Vector2<f64> {
        self.damping * qd
    }
}
