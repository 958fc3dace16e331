//! The projections that eliminate the constraint force from the equation of motion.

use nalgebra::{SMatrix, SVector};

use super::error::ConstraintError;
use super::row_factor::RowFactor;
use robot_dynamics_number::check_finite;

use crate::{Dynamics, solve_mass};

/// P_u on forces and P on velocities, both N×N of rank N − K.
///
/// Every velocity is the sum of P q̇, which A allows, and (1−P) q̇, which A forbids. The two are orthogonal
/// in M, so their kinetic energies add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintProjections<const N: usize> {
    /// P_u = 1 − Aᵀ(AM⁻¹Aᵀ)⁻¹AM⁻¹: P_u Aᵀ = 0. **(PRM 10.18)**
    pub force: SMatrix<f64, N, N>,
    /// P = M⁻¹P_uM = P_uᵀ: A P = 0. **(PRM 10.19)**
    pub velocity: SMatrix<f64, N, N>,
}

impl<const N: usize> ConstraintProjections<N> {
    /// From the mass matrix M (N×N) and the rows A (K×N).
    ///
    /// ```
    /// use dynamics::ConstraintProjections;
    /// use nalgebra::matrix;
    /// let mass = matrix![2.0, 0.5; 0.5, 1.0];
    /// let rows = matrix![1.0, -1.0];
    /// let p = ConstraintProjections::new(&mass, &rows).unwrap();
    /// assert!((rows * p.velocity).norm() < 1e-15);
    /// assert!((mass * p.velocity - p.force * mass).norm() < 1e-15);
    /// ```
    ///
    /// # Errors
    /// As [`RowFactor::new`].
    pub fn new<const K: usize>(
        mass: &SMatrix<f64, N, N>,
        rows: &SMatrix<f64, K, N>,
    ) -> Result<Self, ConstraintError> {
        let factor = RowFactor::new(mass, rows)?;
        // With A = T E, the middle factor cancels: P_u = 1 − Eᵀ E M⁻¹.
        let force = SMatrix::identity() - factor.forces.transpose() * factor.responses;
        Ok(Self { force, velocity: force.transpose() })
    }
}

/// P q̈ = P M⁻¹(u − Cq̇ − g − b): the part of the acceleration without λ. **(PRM 10.20)**
///
/// The rest, (1−P) q̈ = −M⁻¹Aᵀ(AM⁻¹Aᵀ)⁻¹ Ȧq̇, is determined by the constraint alone.
///
/// ```
/// use dynamics::{KnifeEdge, Pfaffian, reduced_acceleration};
/// use nalgebra::vector;
/// // Along the blade the body of 2 kg feels what of the force points that way.
/// let blade = KnifeEdge::new(2.0, 0.5);
/// let (q, u) = (vector![0.0, 0.0, 0.4], vector![1.0, 0.5, 0.1]);
/// let qd = KnifeEdge::velocity(&q, 3.0, 1.5);
/// let reduced = reduced_acceleration(&blade.body, &q, &qd, &u, &blade.rows(&q))?;
/// let ahead = (0.4_f64.cos() + 0.5 * 0.4_f64.sin()) / 2.0;
/// assert!((KnifeEdge::forward_speed(&q, &reduced) - ahead).abs() < 1e-15);
/// assert!((reduced[2] - 0.1 / 0.5).abs() < 1e-15);
/// # Ok::<(), dynamics::ConstraintError>(())
/// ```
///
/// # Errors
/// As [`constrained_forward_dynamics`](super::constrained_forward_dynamics).
pub fn reduced_acceleration<D: Dynamics<N> + ?Sized, const K: usize, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    rows: &SMatrix<f64, K, N>,
) -> Result<SVector<f64, N>, ConstraintError> {
    check_finite("q", q.as_slice())?;
    check_finite("qd", qd.as_slice())?;
    check_finite("u", u.as_slice())?;
    let mass = system.mass(q);
    let free = solve_mass(&mass, &(u - system.bias(q, qd)))?;
    Ok(RowFactor::new(&mass, rows)?.project_velocity(&free))
}
