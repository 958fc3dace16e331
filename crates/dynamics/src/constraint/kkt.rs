//! Acceleration and constraint force together: the KKT system.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::error::ConstraintError;
use super::mass_factor::MassFactor;
use super::row_factor::{RowFactor, check_rows};
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use crate::{Dynamics, solve_mass};

/// q̈ (N) and λ (K) of \[M −Aᵀ; A 0\]\[q̈; λ\] = \[u − Cq̇ − g − b; −Ȧq̇\]. **(PRM 10.16–10.17)**
///
/// The constraint force is Aᵀλ \[N or N·m\], A is K×N and `rows_rate` is Ȧ. Only an error allocates memory.
/// With A = T E ([`RowFactor`]) and the free acceleration a₀ = M⁻¹(u − Cq̇ − g − b): w = T⁻¹(−Ȧq̇) − E a₀,
/// q̈ = a₀ + M⁻¹Eᵀ w, Tᵀλ = w. One step of iterative refinement follows.
///
/// ```
/// use dynamics::{Dynamics, Reach2R, constrained_forward_dynamics};
/// use nalgebra::{matrix, vector};
/// // Joint 2 locked: joint 1 feels M11 alone.
/// let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0);
/// let (q, rest) = (vector![0.0, 1.2], vector![0.0, 0.0]);
/// let lock = matrix![0.0, 1.0];
/// let (qdd, lambda) =
///     constrained_forward_dynamics(&arm, &q, &rest, &vector![3.0, 0.0], &lock, &(lock * 0.0)).unwrap();
/// assert!((qdd[0] - 3.0 / arm.mass(&q)[(0, 0)]).abs() < 1e-12);
/// assert!((lambda[0] - arm.mass(&q)[(1, 0)] * qdd[0]).abs() < 1e-12);
/// ```
///
/// # Errors
/// [`ConstraintError`] if an input is not finite, M is singular, or rows of A depend on each other.
#[doc(alias = "KKT")]
pub fn constrained_forward_dynamics<D: Dynamics<N> + ?Sized, const K: usize, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    rows: &SMatrix<f64, K, N>,
    rows_rate: &SMatrix<f64, K, N>,
) -> Result<(SVector<f64, N>, SVector<f64, K>), ConstraintError> {
    let force = checked_force(system, q, qd, u, rows_rate)?;
    let mass = system.mass(q);
    let mass_factor = MassFactor::new(&mass)?;
    let factor = RowFactor::from_mass_factor(&mass_factor, rows)?;
    let solve = |force: &SVector<f64, N>, target: &SVector<f64, K>| {
        let free = mass_factor.solve(force);
        let w = factor.solve_triangle(target) - factor.forces * free;
        (free + factor.responses.transpose() * w, factor.solve_triangle_transposed(&w))
    };
    let target = -(rows_rate * qd);
    let (mut qdd, mut lambda) = solve(&force, &target);
    // One step of refinement: if M is ill-conditioned, a₀ and its rounding can be much larger than q̈.
    let (correction, lambda_correction) =
        solve(&(force + rows.transpose() * lambda - mass * qdd), &(target - rows * qdd));
    qdd += correction;
    lambda += lambda_correction;
    Ok((qdd, lambda))
}

/// The same q̈ and λ by LU with full pivoting of the whole (N+K)×(N+K) matrix. **(PRM 10.16–10.17)**
///
/// It shares only the equation with [`constrained_forward_dynamics`], so that each checks the other. It
/// allocates, and it names only the dependent rows that the factorisation of A finds first.
///
/// ```
/// use dynamics::{KnifeEdge, Pfaffian, constrained_forward_dynamics_by_lu};
/// use nalgebra::vector;
/// // A blade that runs ahead and turns: the floor pushes sideways, and does not work.
/// let blade = KnifeEdge::new(2.0, 0.5);
/// let (q, u) = (vector![0.0, 0.0, 0.4], vector![0.3, -0.2, 0.1]);
/// let qd = KnifeEdge::velocity(&q, 3.0, 1.5);
/// let (rows, rate) = (blade.rows(&q), blade.rows_rate(&q, &qd));
/// let (qdd, lambda) = constrained_forward_dynamics_by_lu(&blade.body, &q, &qd, &u, &rows, &rate)?;
/// assert!((lambda[0] - blade.side_force(&q, &qd, &u)).abs() < 1e-13);
/// assert!((rows * qdd + rate * qd).norm() < 1e-13); // A q̈ + Ȧ q̇ = 0
/// # Ok::<(), dynamics::ConstraintError>(())
/// ```
///
/// # Errors
/// As [`constrained_forward_dynamics`].
pub fn constrained_forward_dynamics_by_lu<D: Dynamics<N> + ?Sized, const K: usize, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    rows: &SMatrix<f64, K, N>,
    rows_rate: &SMatrix<f64, K, N>,
) -> Result<(SVector<f64, N>, SVector<f64, K>), ConstraintError> {
    let force = checked_force(system, q, qd, u, rows_rate)?;
    let mass = system.mass(q);
    solve_mass(&mass, &force)?;
    RowFactor::new(&mass, rows)?;
    let mut matrix = DMatrix::<f64>::zeros(N + K, N + K);
    matrix.view_mut((0, 0), (N, N)).copy_from(&mass);
    matrix.view_mut((0, N), (N, K)).copy_from(&-rows.transpose());
    matrix.view_mut((N, 0), (K, N)).copy_from(rows);
    let mut right = DVector::<f64>::zeros(N + K);
    right.rows_mut(0, N).copy_from(&force);
    right.rows_mut(N, K).copy_from(&-(rows_rate * qd));
    // M ≻ 0 and independent rows make the matrix invertible; the last pivot can still underflow.
    let Some(solution) = matrix.full_piv_lu().solve(&right) else {
        return Err(ConstraintError::ZeroPivot);
    };
    Ok((SVector::from_fn(|i, _| solution[i]), SVector::from_fn(|i, _| solution[N + i])))
}

/// u − Cq̇ − g − b; an error if an input is not finite.
fn checked_force<D: Dynamics<N> + ?Sized, const K: usize, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    rows_rate: &SMatrix<f64, K, N>,
) -> Result<SVector<f64, N>, ConstraintError> {
    check_finite("q", q.as_slice())?;
    check_finite("qd", qd.as_slice())?;
    check_finite("u", u.as_slice())?;
    check_rows("Ȧ", rows_rate)?;
    let force = u - system.bias(q, qd);
    check_computed("u − C q̇ − g − b", force.as_slice())?;
    Ok(force)
}
