//! The Lagrange recipe for planar bodies: from the Jacobians of their motion to M, V and g.

use robot_dynamics_number::Scalar;

/// One rigid body of a planar mechanism of `N` coordinates, at one configuration.
///
/// Its centre of mass moves with ċ = J_c q̇ and it turns with ω = J_ω q̇. Its kinetic energy is
/// ½ m |J_c q̇|² + ½ I (J_ω q̇)². The world's y axis points up; gravity acts along −y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyJacobian<S, const N: usize> {
    /// Mass m \[kg\].
    pub mass: f64,
    /// Moment of inertia I about the centre of mass \[kg·m²\].
    pub inertia: f64,
    /// Height y_c of the centre of mass \[m\].
    pub height: S,
    /// J_c, 2×N: row 0 is x, row 1 is y \[m per unit of q\].
    pub centre: [[S; N]; 2],
    /// J_ω, 1×N \[rad per unit of q\].
    pub rotation: [S; N],
}

/// M = Σ (m J_cᵀJ_c + I J_ωᵀJ_ω), N×N symmetric. **(PRM 10.6)**
///
/// ```
/// use dynamics::{BodyJacobian, mass_from_bodies};
/// // A rod of 3 kg and 1 m that turns about its end, at the angle q: m l²/3.
/// let q = 0.4_f64;
/// let centre = [[-0.5 * q.sin()], [0.5 * q.cos()]];
/// let rod = BodyJacobian { mass: 3.0, inertia: 3.0 / 12.0, height: 0.5 * q.sin(), centre, rotation: [1.0] };
/// let [[mass]] = mass_from_bodies(&[rod]);
/// assert!((mass - 1.0).abs() < 1e-15);
/// ```
pub fn mass_from_bodies<S: Scalar, const N: usize>(bodies: &[BodyJacobian<S, N>]) -> [[S; N]; N] {
    let mut mass = [[S::zero(); N]; N];
    for body in bodies {
        let [x, y] = &body.centre;
        let turn = &body.rotation;
        for i in 0..N {
            for j in 0..=i {
                let entry =
                    (x[i] * x[j] + y[i] * y[j]).scale(body.mass) + (turn[i] * turn[j]).scale(body.inertia);
                mass[i][j] += entry;
            }
        }
    }
    for i in 0..N {
        for j in 0..i {
            mass[j][i] = mass[i][j];
        }
    }
    mass
}

/// V = Σ m a_g y_c \[J\].
///
/// ```
/// use dynamics::{BodyJacobian, potential_from_bodies};
/// // Two weights on one rope: what one gains the other loses.
/// let weight = |height: f64, up: f64| BodyJacobian {
///     mass: 2.0, inertia: 0.0, height, centre: [[0.0], [up]], rotation: [0.0],
/// };
/// assert!((potential_from_bodies(&[weight(1.5, 1.0)], 9.81) - 2.0 * 9.81 * 1.5).abs() < 1e-14);
/// assert_eq!(potential_from_bodies(&[weight(1.5, 1.0), weight(-1.5, -1.0)], 9.81), 0.0);
/// ```
pub fn potential_from_bodies<S: Scalar, const N: usize>(bodies: &[BodyJacobian<S, N>], a_g: f64) -> S {
    bodies.iter().fold(S::zero(), |sum, body| sum + body.height.scale(body.mass * a_g))
}

/// g = Σ m a_g (y row of J_c)ᵀ: gravity from the Jacobians alone, without a derivative of V.
///
/// ```
/// use dynamics::{BodyJacobian, gravity_from_bodies, potential_from_bodies};
/// use robot_dynamics_number::{Dual, Scalar};
/// // A weight of 2 kg on an arm of 0.5 m, over dual numbers: g is the derivative of V, m a_g l cos q.
/// let [q] = Dual::<f64, 1>::variables(&[0.4]);
/// let (sin, cos) = q.sin_cos();
/// let (centre, rotation) = ([[sin.scale(-0.5)], [cos.scale(0.5)]], [Dual::one()]);
/// let weight = [BodyJacobian { mass: 2.0, inertia: 0.0, height: sin.scale(0.5), centre, rotation }];
/// let [gravity] = gravity_from_bodies(&weight, 9.81);
/// assert!((gravity.value - 2.0 * 9.81 * 0.5 * 0.4_f64.cos()).abs() < 1e-14);
/// assert!((gravity.value - potential_from_bodies(&weight, 9.81).gradient[0]).abs() < 1e-14);
/// ```
pub fn gravity_from_bodies<S: Scalar, const N: usize>(bodies: &[BodyJacobian<S, N>], a_g: f64) -> [S; N] {
    let mut gravity = [S::zero(); N];
    for body in bodies {
        for i in 0..N {
            gravity[i] += body.centre[1][i].scale(body.mass * a_g);
        }
    }
    gravity
}
