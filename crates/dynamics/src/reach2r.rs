//! The planar two-link arm, in closed form.

use nalgebra::{SMatrix, SVector, matrix, vector};
use robot_dynamics_number::Scalar;

use crate::{Christoffel, Dynamics, Lagrangian, Link, PlanarArm, PlanarKinematics};

/// A planar arm of two revolute joints in a vertical plane. **(PRM ex. 10.1.1; MR §8.1.1)**
///
/// q = (q1, q2) \[rad\]: q1 from the horizontal x axis to link 1, q2 from link 1 to link 2, both
/// counter-clockwise. With c = cos q2, h = m2 l1 r2 sin q2:
///
/// - M11 = I1 + I2 + m1 r1² + m2(l1² + r2² + 2 l1 r2 c), M12 = I2 + m2(r2² + l1 r2 c), M22 = I2 + m2 r2²
/// - C q̇ = (−2h q̇1 q̇2 − h q̇2², h q̇1²)
/// - V = m1 a_g r1 sin q1 + m2 a_g (l1 sin q1 + r2 sin(q1+q2))
///
/// ```
/// use dynamics::{Dynamics, Reach2R};
/// use nalgebra::vector;
/// let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81);
/// // Folding the arm shrinks the inertia that joint 1 feels from 3 to 1 kg·m².
/// assert!((arm.mass(&vector![0.0, 0.0])[(0, 0)] - 3.0).abs() < 1e-12);
/// assert!((arm.mass(&vector![0.0, std::f64::consts::PI])[(0, 0)] - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach2R {
    /// Length of link 1 \[m\].
    pub l1: f64,
    /// Distance from joint 1 to the centre of mass of link 1 \[m\].
    pub r1: f64,
    /// Mass of link 1 \[kg\].
    pub m1: f64,
    /// Moment of inertia of link 1 about its centre of mass \[kg·m²\].
    pub i1: f64,
    /// Length of link 2 \[m\].
    pub l2: f64,
    /// Distance from joint 2 to the centre of mass of link 2 \[m\].
    pub r2: f64,
    /// Mass of link 2 \[kg\].
    pub m2: f64,
    /// Moment of inertia of link 2 about its centre of mass \[kg·m²\].
    pub i2: f64,
    /// Gravitational acceleration along −y \[m/s²\]; 0 for an arm on a horizontal table.
    pub a_g: f64,
}

impl Reach2R {
    /// Two uniform thin rods: r = l/2, I = m l²/12.
    pub fn uniform(l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64) -> Self {
        let rod = |length: f64, mass: f64| mass * length * length / 12.0;
        Self { l1, r1: l1 / 2.0, m1, i1: rod(l1, m1), l2, r2: l2 / 2.0, m2, i2: rod(l2, m2), a_g }
    }

    /// The arm of the chapter's worked example: rods of 1 m, 2 kg and 1 m, 1 kg in Earth gravity.
    pub fn worked_example() -> Self {
        Self::uniform(1.0, 2.0, 1.0, 1.0, 9.81)
    }

    /// Γ in closed form: Γ¹₁₂ = Γ¹₂₁ = Γ¹₂₂ = −h, Γ²₁₁ = h, the rest 0. **(PRM 10.9)**
    pub fn christoffel(&self, q: &SVector<f64, 2>) -> Christoffel<2> {
        let h = self.coupling(q);
        Christoffel::from_table([[[0.0, -h], [-h, -h]], [[h, 0.0], [0.0, 0.0]]])
    }

    /// h = m2 l1 r2 sin q2 \[kg·m²\].
    fn coupling(&self, q: &SVector<f64, 2>) -> f64 {
        self.m2 * self.l1 * self.r2 * q[1].sin()
    }
}

impl Dynamics<2> for Reach2R {
    fn mass(&self, q: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        let [[m11, m12], [m21, m22]] = self.mass_over(&q.data.0[0]);
        matrix![m11, m12; m21, m22]
    }

    fn velocity_product(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SVector<f64, 2> {
        let h = self.coupling(q);
        vector![-2.0 * h * qd[0] * qd[1] - h * qd[1] * qd[1], h * qd[0] * qd[0]]
    }

    fn gravity(&self, q: &SVector<f64, 2>) -> SVector<f64, 2> {
        let outer = self.m2 * self.a_g * self.r2 * (q[0] + q[1]).cos();
        let inner = (self.m1 * self.r1 + self.m2 * self.l1) * self.a_g * q[0].cos();
        vector![inner + outer, outer]
    }

    fn potential_energy(&self, q: &SVector<f64, 2>) -> f64 {
        self.potential_over(&q.data.0[0])
    }
}

impl Lagrangian<2> for Reach2R {
    fn mass_over<S: Scalar>(&self, q: &[S; 2]) -> [[S; 2]; 2] {
        let Self { l1, r1, m1, i1, r2, m2, i2, .. } = *self;
        let cosine = q[1].sin_cos().1;
        let m11 =
            cosine.scale(2.0 * m2 * l1 * r2) + S::from_f64(i1 + i2 + m1 * r1 * r1 + m2 * (l1 * l1 + r2 * r2));
        let m12 = cosine.scale(m2 * l1 * r2) + S::from_f64(i2 + m2 * r2 * r2);
        [[m11, m12], [m12, S::from_f64(i2 + m2 * r2 * r2)]]
    }

    fn potential_over<S: Scalar>(&self, q: &[S; 2]) -> S {
        let Self { l1, r1, m1, r2, m2, a_g, .. } = *self;
        q[0].sin_cos().0.scale((m1 * r1 + m2 * l1) * a_g) + (q[0] + q[1]).sin_cos().0.scale(m2 * r2 * a_g)
    }
}

/// The same arm as a chain of links, for functions of any number of links.
impl From<Reach2R> for PlanarArm<2> {
    fn from(arm: Reach2R) -> Self {
        let inner = Link { length: arm.l1, centre: arm.r1, mass: arm.m1, inertia: arm.i1 };
        let outer = Link { length: arm.l2, centre: arm.r2, mass: arm.m2, inertia: arm.i2 };
        Self { links: [inner, outer], a_g: arm.a_g }
    }
}

impl PlanarKinematics<2> for Reach2R {
    /// Body 0 is link 1, body 1 is link 2, as in [`PlanarArm`]; the tip is the point (l2, 0) of body 1.
    fn point_over<S: Scalar>(&self, q: &[S; 2], body: usize, point: [f64; 2]) -> [S; 2] {
        PlanarArm::from(*self).point_over(q, body, point)
    }
}
