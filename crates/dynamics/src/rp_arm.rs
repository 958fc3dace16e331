//! The arm with one revolute and one prismatic joint, in closed form.

use nalgebra::{SMatrix, SVector, matrix, vector};
use robot_dynamics_number::Scalar;

use crate::{Christoffel, Dynamics, Lagrangian};

/// A planar arm with a rotating and a sliding link, in a vertical plane. **(PRM ex. 10.1.2, 10.2.1)**
///
/// q = (q1 \[rad\], q2 \[m\]): q1 from the horizontal x axis to the arm, counter-clockwise; q2 from the
/// revolute joint to the centre of mass of the sliding link.
///
/// M = diag(I1 + I2 + m1 r1² + m2 q2², m2), Γ¹₁₂ = Γ¹₂₁ = m2 q2, Γ²₁₁ = −m2 q2,
/// C q̇ = (2 m2 q2 q̇1 q̇2, −m2 q2 q̇1²), V = a_g (m1 r1 + m2 q2) sin q1.
///
/// ```
/// use dynamics::{Dynamics, RpArm};
/// use nalgebra::vector;
/// let arm = RpArm { r1: 0.4, m1: 2.0, i1: 0.1, m2: 1.5, i2: 0.05, a_g: 9.81 };
/// // Sliding out while turning takes a torque 2 m2 q2 q̇1 q̇2; turning flings the slider outwards.
/// let product = arm.velocity_product(&vector![0.3, 0.8], &vector![2.0, 0.5]);
/// assert!((product - vector![2.4, -4.8]).norm() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RpArm {
    /// Distance from the revolute joint to the centre of mass of the turning link \[m\].
    pub r1: f64,
    /// Mass of the turning link \[kg\].
    pub m1: f64,
    /// Moment of inertia of the turning link about its centre of mass \[kg·m²\].
    pub i1: f64,
    /// Mass of the sliding link \[kg\].
    pub m2: f64,
    /// Moment of inertia of the sliding link about its centre of mass \[kg·m²\].
    pub i2: f64,
    /// Gravitational acceleration along −y \[m/s²\].
    pub a_g: f64,
}

impl RpArm {
    /// Γ in closed form: Γ¹₁₂ = Γ¹₂₁ = m2 q2, Γ²₁₁ = −m2 q2, the rest 0. **(PRM ex. 10.2.1)**
    pub fn christoffel(&self, q: &SVector<f64, 2>) -> Christoffel<2> {
        let moment = self.m2 * q[1];
        Christoffel::from_table([[[0.0, moment], [moment, 0.0]], [[-moment, 0.0], [0.0, 0.0]]])
    }
}

impl Dynamics<2> for RpArm {
    fn mass(&self, q: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        let [[m11, m12], [m21, m22]] = self.mass_over(&q.data.0[0]);
        matrix![m11, m12; m21, m22]
    }

    fn velocity_product(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SVector<f64, 2> {
        let moment = self.m2 * q[1];
        vector![2.0 * moment * qd[0] * qd[1], -moment * qd[0] * qd[0]]
    }

    fn gravity(&self, q: &SVector<f64, 2>) -> SVector<f64, 2> {
        let (sine, cosine) = q[0].sin_cos();
        vector![self.a_g * (self.m1 * self.r1 + self.m2 * q[1]) * cosine, self.a_g * self.m2 * sine]
    }

    fn potential_energy(&self, q: &SVector<f64, 2>) -> f64 {
        self.potential_over(&q.data.0[0])
    }
}

impl Lagrangian<2> for RpArm {
    fn mass_over<S: Scalar>(&self, q: &[S; 2]) -> [[S; 2]; 2] {
        let turning = S::from_f64(self.i1 + self.i2 + self.m1 * self.r1 * self.r1);
        [[turning + (q[1] * q[1]).scale(self.m2), S::zero()], [S::zero(), S::from_f64(self.m2)]]
    }

    fn potential_over<S: Scalar>(&self, q: &[S; 2]) -> S {
        let moment = q[1].scale(self.m2) + S::from_f64(self.m1 * self.r1);
        (moment * q[0].sin_cos().0).scale(self.a_g)
    }
}
