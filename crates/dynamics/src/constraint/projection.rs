//! The projections that take the constraint force out of the equation of motion.

use nalgebra::{SMatrix, SVector};

use super::error::ConstraintError;
use super::row_factor::RowFactor;
use crate::{Dynamics, check_finite, solve_mass};

/// P_u on forces and P on velocities, both N×N of rank N − K.
///
/// Every velocity splits into P q̇, which A allows, and (1−P) q̇, which it forbids; the two are orthogonal
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

/// P q̈ = P M⁻¹(u − Cq̇ − g − b): the part of the acceleration that needs no λ. **(PRM 10.20)**
///
/// The rest, (1−P) q̈ = −M⁻¹Aᵀ(AM⁻¹Aᵀ)⁻¹ Ȧq̇, is fixed by the constraint alone.
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
