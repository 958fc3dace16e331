//! Quantities drawn on a planar arm: link ends, weights, and the mobility of the tip.

use dynamics::{Dynamics, IntegratorError, PlanarArm, PlanarKinematics, solve_mass, symmetric_eigen};
use nalgebra::{SMatrix, SVector};

/// The end of every link, from the base outwards: x, y, x, y, … \[m\].
pub(crate) fn link_ends<const N: usize>(arm: &PlanarArm<N>, q: &SVector<f64, N>) -> Vec<f64> {
    (0..N).flat_map(|k| arm.point_over(&q.data.0[0], k, [arm.links[k].length, 0.0])).collect()
}

/// Every link's centre of mass and weight: x, y \[m\], m a_g \[N\], for one link after another.
pub(crate) fn weights<const N: usize>(arm: &PlanarArm<N>, q: &SVector<f64, N>) -> Vec<f64> {
    let weight = |k: usize| {
        let link = &arm.links[k];
        let [x, y] = arm.point_over(&q.data.0[0], k, [link.centre, 0.0]);
        [x, y, link.mass * arm.a_g]
    };
    (0..N).flat_map(weight).collect()
}

/// J M⁻¹ Jᵀ of a point with Jacobian J: its acceleration at rest for a force of 1 N, by direction \[1/kg\].
///
/// # Errors
/// Fails if M is singular.
pub(crate) fn mobility<const N: usize>(
    mass: &SMatrix<f64, N, N>,
    jacobian: &SMatrix<f64, 2, N>,
) -> Result<SMatrix<f64, 2, 2>, IntegratorError> {
    let [x, y] = [0, 1].map(|row| solve_mass(mass, &jacobian.row(row).transpose()));
    let (x, y) = (jacobian * x?, jacobian * y?);
    // Symmetric up to rounding.
    let off = x[1].midpoint(y[0]);
    Ok(SMatrix::<f64, 2, 2>::new(x[0], off, off, y[1]))
}

/// The tip's mobility in principal axes: the larger eigenvalue, the smaller \[1/kg\], and the direction of
/// the larger, x and y. The inverse eigenvalues are the effective masses at the tip. **(Khatib 1987)**
///
/// # Errors
/// Fails if M is singular.
pub(crate) fn tip_mobility<const N: usize>(
    arm: &PlanarArm<N>,
    q: &SVector<f64, N>,
) -> Result<Vec<f64>, IntegratorError> {
    let jacobian = arm.point_jacobian(q, N - 1, [arm.links[N - 1].length, 0.0]);
    let (values, vectors) = symmetric_eigen(&mobility(&arm.mass(q), &jacobian)?);
    let (greater, smaller) = if values[0] >= values[1] { (0, 1) } else { (1, 0) };
    // The tip of a stretched arm cannot move outwards: the eigenvalue is zero up to rounding.
    Ok(vec![values[greater], values[smaller].max(0.0), vectors[(0, greater)], vectors[(1, greater)]])
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;

    use super::*;

    /// The arm of the worked example, bent at a right angle, with M⁻¹ and J of the tip by hand.
    #[test]
    fn the_tip_moves_as_newton_says() {
        let arm = PlanarArm::from(dynamics::Reach2R::worked_example());
        let q = vector![0.0, core::f64::consts::FRAC_PI_2];
        // J = [[−1, −1], [1, 0]], M = [[2, 1/3], [1/3, 1/3]]: J M⁻¹ Jᵀ = [[3, 0], [0, 0.6]].
        let found = tip_mobility(&arm, &q).unwrap();
        let expected = [3.0, 0.6, 1.0, 0.0];
        for (f, e) in found.iter().zip(expected) {
            assert!((f.abs() - e).abs() < 1e-12, "{found:?}");
        }
        let stretched = tip_mobility(&arm, &vector![0.3, 0.0]).unwrap();
        assert!(stretched[1] < 1e-12, "{stretched:?}");
        assert!((weights(&arm, &q)[2] - 2.0 * 9.81).abs() < 1e-12);
        assert_eq!(link_ends(&arm, &vector![0.0, 0.0]), [1.0, 0.0, 2.0, 0.0]);
    }
}
