//! The Lagrange recipe for planar bodies: from the Jacobians of their motion to M, V and g.

use crate::Scalar;

/// One rigid body of a planar mechanism of `N` coordinates, at one configuration.
///
/// Its centre of mass moves with ċ = J_c q̇ and it turns with ω = J_ω q̇, so its kinetic energy is
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
pub fn potential_from_bodies<S: Scalar, const N: usize>(bodies: &[BodyJacobian<S, N>], a_g: f64) -> S {
    bodies.iter().fold(S::zero(), |sum, body| sum + body.height.scale(body.mass * a_g))
}

/// g = Σ m a_g (y row of J_c)ᵀ: gravity from the Jacobians alone, without a derivative of V.
pub fn gravity_from_bodies<S: Scalar, const N: usize>(bodies: &[BodyJacobian<S, N>], a_g: f64) -> [S; N] {
    let mut gravity = [S::zero(); N];
    for body in bodies {
        for i in 0..N {
            gravity[i] += body.centre[1][i].scale(body.mass * a_g);
        }
    }
    gravity
}
