//! A point mass in polar coordinates: an example of C q̇ without a mechanism.

use nalgebra::{SMatrix, SVector, matrix, vector};
use robot_dynamics_number::Scalar;

use crate::{Christoffel, Dynamics, Lagrangian};

/// A point mass in the plane, described by its distance and direction from the origin. **(PRM problem 10.1)**
///
/// q = (r \[m\], θ \[rad\]), θ from the horizontal x axis, counter-clockwise:
///
/// M = diag(m, m r²), Γ¹₂₂ = −m r, Γ²₁₂ = Γ²₂₁ = m r, C q̇ = (−m r θ̇², 2 m r ṙ θ̇), V = m a_g r sin θ.
///
/// Without gravity and force the mass moves on a straight line; C q̇ comes from the curvature of the
/// coordinates, not from a force. At r = 0 the direction θ has no inertia: M is singular there, and
/// [`try_forward`](Dynamics::try_forward) returns an error.
///
/// ```
/// use dynamics::PolarMass;
/// use nalgebra::vector;
/// let symbols = PolarMass { m: 2.0, a_g: 0.0 }.christoffel(&vector![1.5, 0.7]);
/// assert_eq!(symbols.get(1, 0, 1), 3.0); // Γ²₁₂ = m r, counted from zero
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarMass {
    /// Mass \[kg\].
    pub m: f64,
    /// Gravitational acceleration along −y \[m/s²\]; 0 for a frictionless table.
    pub a_g: f64,
}

impl PolarMass {
    /// Γ in closed form: Γ¹₂₂ = −m r, Γ²₁₂ = Γ²₂₁ = m r, the rest 0. **(PRM 10.9)**
    pub fn christoffel(&self, q: &SVector<f64, 2>) -> Christoffel<2> {
        let moment = self.m * q[0];
        Christoffel::from_table([[[0.0, 0.0], [0.0, -moment]], [[0.0, moment], [moment, 0.0]]])
    }
}

impl Dynamics<2> for PolarMass {
    fn mass(&self, q: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        let [[m11, m12], [m21, m22]] = self.mass_over(&q.data.0[0]);
        matrix![m11, m12; m21, m22]
    }

    fn velocity_product(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SVector<f64, 2> {
        let moment = self.m * q[0];
        vector![-moment * qd[1] * qd[1], 2.0 * moment * qd[0] * qd[1]]
    }

    fn gravity(&self, q: &SVector<f64, 2>) -> SVector<f64, 2> {
        let (sine, cosine) = q[1].sin_cos();
        vector![sine, q[0] * cosine] * (self.m * self.a_g)
    }

    fn potential_energy(&self, q: &SVector<f64, 2>) -> f64 {
        self.potential_over(&q.data.0[0])
    }
}

impl Lagrangian<2> for PolarMass {
    fn mass_over<S: Scalar>(&self, q: &[S; 2]) -> [[S; 2]; 2] {
        [[S::from_f64(self.m), S::zero()], [S::zero(), (q[0] * q[0]).scale(self.m)]]
    }

    fn potential_over<S: Scalar>(&self, q: &[S; 2]) -> S {
        (q[0] * q[1].sin_cos().0).scale(self.m * self.a_g)
    }
}
