//! The planar arm of N revolute joints, from the Jacobians of its centres of mass.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_number::Scalar;

use crate::{
    BodyJacobian, Dynamics, Lagrangian, PlanarKinematics, christoffel, gravity_from_bodies, mass_from_bodies,
    potential_from_bodies,
};

/// One link of a planar arm; its joint is at its origin and the next joint at distance `length`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Length L, from this joint to the next \[m\].
    pub length: f64,
    /// Distance r from this joint to the centre of mass, on the line to the next joint \[m\].
    pub centre: f64,
    /// Mass m \[kg\].
    pub mass: f64,
    /// Moment of inertia I about the centre of mass \[kg·m²\].
    pub inertia: f64,
}

impl Link {
    /// A uniform thin rod: r = L/2, I = m L²/12.
    pub fn rod(length: f64, mass: f64) -> Self {
        Self { length, centre: length / 2.0, mass, inertia: mass * length * length / 12.0 }
    }
}

/// A planar arm of `N` revolute joints in a vertical plane. **(MR §8.1.1)**
///
/// q \[rad\]: q₁ from the horizontal x axis to link 1, every further qᵢ from link i−1 to link i, all
/// counter-clockwise. With θᵢ = q₁ + … + qᵢ, the centre of mass of link k is at c_k = Σ_{i<k} Lᵢ (cos θᵢ, sin
/// θᵢ) + r_k (cos θ_k, sin θ_k). For j ≤ k joint j moves it by ∂c_k/∂qⱼ = ẑ × (c_k − pⱼ), with pⱼ the
/// position of joint j. M and g follow from these Jacobians ([`mass_from_bodies`]), C q̇ from exact
/// derivatives of M ([`christoffel`]).
///
/// ```
/// use dynamics::{Dynamics, Link, PlanarArm, Reach2R};
/// use nalgebra::vector;
/// let recipe = PlanarArm { links: [Link::rod(1.0, 2.0), Link::rod(1.0, 1.0)], a_g: 9.81 };
/// let closed_form = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81);
/// let q = vector![0.4, -1.1];
/// assert!((recipe.mass(&q) - closed_form.mass(&q)).norm() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarArm<const N: usize> {
    /// The links, from the base outwards.
    pub links: [Link; N],
    /// Gravitational acceleration along −y \[m/s²\]; 0 for an arm on a horizontal table.
    pub a_g: f64,
}

/// The planar arm of three joints; [`Reach3R::reach_3r`] has the default links.
pub type Reach3R = PlanarArm<3>;

impl PlanarArm<3> {
    /// Three uniform rods of 0.6, 0.5, 0.4 m and 1.2, 1.0, 0.8 kg, in Earth gravity.
    pub fn reach_3r() -> Self {
        Self { links: [Link::rod(0.6, 1.2), Link::rod(0.5, 1.0), Link::rod(0.4, 0.8)], a_g: 9.81 }
    }
}

impl<const N: usize> PlanarArm<N> {
    /// Mass, height and Jacobians of every link at q.
    pub fn bodies_over<S: Scalar>(&self, q: &[S; N]) -> [BodyJacobian<S, N>; N] {
        let mut angle = S::zero();
        let mut joint = [S::zero(); 2];
        let mut joints = [[S::zero(); 2]; N];
        core::array::from_fn(|k| {
            let link = &self.links[k];
            joints[k] = joint;
            angle += q[k];
            let (sine, cosine) = angle.sin_cos();
            let centre = [joint[0] + cosine.scale(link.centre), joint[1] + sine.scale(link.centre)];
            joint = [joint[0] + cosine.scale(link.length), joint[1] + sine.scale(link.length)];
            let mut body = BodyJacobian {
                mass: link.mass,
                inertia: link.inertia,
                height: centre[1],
                centre: [[S::zero(); N]; 2],
                rotation: [S::zero(); N],
            };
            for j in 0..=k {
                // ẑ × (x, y) = (−y, x).
                body.centre[0][j] = joints[j][1] - centre[1];
                body.centre[1][j] = centre[0] - joints[j][0];
                body.rotation[j] = S::one();
            }
            body
        })
    }
}

impl<const N: usize> Lagrangian<N> for PlanarArm<N> {
    fn mass_over<S: Scalar>(&self, q: &[S; N]) -> [[S; N]; N] {
        mass_from_bodies(&self.bodies_over(q))
    }

    fn potential_over<S: Scalar>(&self, q: &[S; N]) -> S {
        potential_from_bodies(&self.bodies_over(q), self.a_g)
    }
}

impl<const N: usize> Dynamics<N> for PlanarArm<N> {
    fn mass(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let mass = self.mass_over(&q.data.0[0]);
        SMatrix::from_fn(|i, j| mass[i][j])
    }

    fn velocity_product(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        christoffel(self, q).velocity_product(qd)
    }

    fn gravity(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        SVector::from(gravity_from_bodies(&self.bodies_over(&q.data.0[0]), self.a_g))
    }

    fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        self.potential_over(&q.data.0[0])
    }

    fn coriolis_matrix(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        christoffel(self, q).coriolis_matrix(qd)
    }
}

impl<const N: usize> PlanarKinematics<N> for PlanarArm<N> {
    /// Body k is link k; its frame is at its joint with x towards the next joint.
    ///
    /// # Panics
    /// If `body ≥ N`.
    fn point_over<S: Scalar>(&self, q: &[S; N], body: usize, point: [f64; 2]) -> [S; 2] {
        assert!(body < N, "this arm has links 0 to {}, there is no link {body}", N - 1);
        let mut angle = S::zero();
        let mut position = [S::zero(); 2];
        for k in 0..=body {
            angle += q[k];
            let (sine, cosine) = angle.sin_cos();
            let [along, across] = if k == body { point } else { [self.links[k].length, 0.0] };
            position[0] += cosine.scale(along) - sine.scale(across);
            position[1] += sine.scale(along) + cosine.scale(across);
        }
        position
    }
}
