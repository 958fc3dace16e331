//! Actuation: the generalized force of forces that act at given places, T(q) f = u.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_number::{Dual, Scalar};

/// The generalized force of actuators that act through T(q): u = T f. **(PRM 10.12)**
///
/// T is N×K for K actuators; column k is the generalized force of one unit of actuator k. The power is equal
/// on both sides: u·q̇ = fᵀ(Tᵀq̇), where Tᵀq̇ is the velocity of the actuators ([`actuator_velocity`]). With
/// K < N the system is underactuated: some u are out of reach.
///
/// ```
/// use dynamics::{actuator_velocity, generalized_force};
/// use nalgebra::{matrix, vector};
/// // A belt drive: motor 2 sits on the base and turns link 2's absolute angle q1 + q2.
/// let map = matrix![1.0, 1.0; 0.0, 1.0];
/// let (f, qd) = (vector![3.0, -2.0], vector![0.5, 0.25]);
/// let u = generalized_force(&map, &f);
/// assert_eq!(u, vector![1.0, -2.0]);
/// assert_eq!(u.dot(&qd), f.dot(&actuator_velocity(&map, &qd)));
/// ```
pub fn generalized_force<const N: usize, const K: usize>(
    map: &SMatrix<f64, N, K>,
    force: &SVector<f64, K>,
) -> SVector<f64, N> {
    map * force
}

/// Tᵀq̇: the velocity at which each actuator works, so that its power is fₖ (Tᵀq̇)ₖ. **(PRM 10.12)**
///
/// ```
/// use dynamics::{KnifeEdge, actuator_velocity};
/// use nalgebra::vector;
/// // A cart of two wheels, 0.4 m apart: the left hub runs at v − wω, the right one at v + wω.
/// let q = vector![0.0, 0.0, 0.7];
/// let hubs = actuator_velocity(&KnifeEdge::wheel_map(&q, 0.2), &KnifeEdge::velocity(&q, 1.5, 2.0));
/// assert!((hubs - vector![1.5 - 0.4, 1.5 + 0.4]).norm() < 1e-15);
/// ```
pub fn actuator_velocity<const N: usize, const K: usize>(
    map: &SMatrix<f64, N, K>,
    qd: &SVector<f64, N>,
) -> SVector<f64, K> {
    map.tr_mul(qd)
}

/// A planar mechanism whose bodies' points have known positions.
///
/// A mechanism implements only the position; its Jacobian is differentiated exactly. World axes: x to the
/// right, y up. Points are in the frame of the body.
pub trait PlanarKinematics<const N: usize> {
    /// The world position \[m\] of the point at `point` \[m, body frame\] of body number `body`.
    ///
    /// # Panics
    /// If there is no such body.
    fn point_over<S: Scalar>(&self, q: &[S; N], body: usize, point: [f64; 2]) -> [S; 2];

    /// J = ∂p/∂q, 2×N: the velocity of the point is ṗ = J q̇ \[world frame\].
    ///
    /// # Panics
    /// If there is no such body.
    fn point_jacobian(&self, q: &SVector<f64, N>, body: usize, point: [f64; 2]) -> SMatrix<f64, 2, N> {
        let position = self.point_over(&Dual::variables(&q.data.0[0]), body, point);
        SMatrix::from_fn(|i, j| position[i].gradient[j])
    }

    /// T = Jᵀ, N×2: a force \[N, world frame\] at that point is the generalized force u = Jᵀf. **(PRM
    /// 10.12)**
    ///
    /// Its power is the same: u·q̇ = f·ṗ.
    ///
    /// ```
    /// use dynamics::{Dynamics, PlanarArm, PlanarKinematics, generalized_force};
    /// use nalgebra::vector;
    /// // Hanging 1 kg from the tip of the 3R arm adds what its weight does at the tip.
    /// let arm = PlanarArm::reach_3r();
    /// let q = vector![0.3, 0.5, -0.2];
    /// let map = arm.force_map(&q, 2, [0.4, 0.0]);
    /// let mut loaded = arm;
    /// loaded.links[2].centre = (0.8 * 0.2 + 1.0 * 0.4) / 1.8; // the common centre of mass
    /// loaded.links[2].mass = 1.8;
    /// let weight = generalized_force(&map, &vector![0.0, -9.81]);
    /// assert!((loaded.gravity(&q) - (arm.gravity(&q) - weight)).norm() < 1e-12);
    /// ```
    ///
    /// # Panics
    /// If there is no such body.
    fn force_map(&self, q: &SVector<f64, N>, body: usize, point: [f64; 2]) -> SMatrix<f64, N, 2> {
        self.point_jacobian(q, body, point).transpose()
    }
}
