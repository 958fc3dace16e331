//! Linearisation of the forward dynamics about a state and a force.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::Dual;

use robot_dynamics_number::check_finite;

use crate::{Christoffel, Dynamics, Lagrangian, solve_mass};

/// The three N×N Jacobians of q̈(q, q̇, u): δq̈ = ∂q̈/∂q δq + ∂q̈/∂q̇ δq̇ + ∂q̈/∂u δu.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Linearization<const N: usize> {
    /// ∂q̈/∂q.
    pub by_position: SMatrix<f64, N, N>,
    /// ∂q̈/∂q̇.
    pub by_velocity: SMatrix<f64, N, N>,
    /// ∂q̈/∂u = M⁻¹.
    pub by_force: SMatrix<f64, N, N>,
}

/// Exact Jacobians of the forward dynamics of a Lagrangian system without dissipation.
///
/// u = ID(q, q̇, q̈) holds for every q̈. At the q̈ of this state ∂q̈/∂q = −M⁻¹ ∂ID/∂q and ∂q̈/∂q̇ = −M⁻¹
/// ∂ID/∂q̇ = −2 M⁻¹C, with C the Christoffel Coriolis matrix. ∂ID/∂q needs ∂Γ/∂q and ∂²V/∂q²: second
/// derivatives, by dual numbers of dual numbers. There is no step size; the error is κ(M) ε. Source:
/// Carpentier, Mansard, *Analytical Derivatives of Rigid Body Dynamics Algorithms* (RSS 2018).
///
/// ```
/// use dynamics::{Reach2R, linearize};
/// use nalgebra::{Vector2, vector};
/// use std::f64::consts::FRAC_PI_2;
/// // Hanging at rest, both links push back to the vertical: ∂q̈1/∂q1 < 0.
/// let at = linearize(&Reach2R::worked_example(), &vector![-FRAC_PI_2, 0.0], &Vector2::zeros(), &Vector2::zeros());
/// assert!(at.unwrap().by_position[(0, 0)] < 0.0);
/// ```
///
/// # Errors
/// If [`Dynamics::try_forward`] fails.
pub fn linearize<L: Lagrangian<N>, const N: usize>(
    system: &L,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
) -> Result<Linearization<N>, IntegratorError> {
    check_finite("q", q.as_slice())?;
    check_finite("qd", qd.as_slice())?;
    check_finite("u", u.as_slice())?;
    // Outer ε: ∂/∂qₖ for the Lagrange recipe. Inner ε: the derivative ∂/∂q of the result.
    let x = Dual::<Dual<f64, N>, N>::variables(&Dual::variables(&q.data.0[0]));
    let (mass, potential) = (system.mass_over(&x), system.potential_over(&x));
    let m = SMatrix::<f64, N, N>::from_fn(|i, j| mass[i][j].value.value);
    let christoffel = Christoffel::from_mass_derivatives(&core::array::from_fn(|k| {
        SMatrix::from_fn(|i, j| mass[i][j].gradient[k].value)
    }));
    let gravity = SVector::<f64, N>::from_fn(|i, _| potential.gradient[i].value);
    let qdd = solve_mass(&m, &(u - christoffel.velocity_product(qd) - gravity))?;
    // ID_i = Σⱼ M_ij q̈ⱼ + Σⱼₖ (∂M_ij/∂qₖ − ½ ∂M_jk/∂qᵢ) q̇ⱼ q̇ₖ + ∂V/∂qᵢ, differentiated by q_l.
    let by_position = SMatrix::<f64, N, N>::from_fn(|i, l| {
        let mut sum = potential.gradient[i].gradient[l];
        for j in 0..N {
            sum += mass[i][j].value.gradient[l] * qdd[j];
            for k in 0..N {
                let symbol = mass[i][j].gradient[k].gradient[l] - 0.5 * mass[j][k].gradient[i].gradient[l];
                sum += symbol * qd[j] * qd[k];
            }
        }
        sum
    });
    let by_velocity = christoffel.coriolis_matrix(qd) * 2.0;
    Ok(Linearization {
        by_position: -solve_columns(&m, &by_position)?,
        by_velocity: -solve_columns(&m, &by_velocity)?,
        by_force: solve_columns(&m, &SMatrix::identity())?,
    })
}

/// The Jacobians by central differences of [`Dynamics::try_forward`], dissipation included; ∂q̈/∂u is exact.
///
/// 4N evaluations of the forward dynamics. The error is O(step²) truncation plus O(ε/step) rounding. If q and
/// q̇ are of order 1, `step` = 1e-5 leaves about 1e-10 relative to the third derivatives of q̈.
///
/// ```
/// use dynamics::{Reach2R, linearize, linearize_by_differences};
/// use nalgebra::vector;
/// let (arm, q, qd, u) = (Reach2R::worked_example(), vector![0.3, 1.2], vector![1.0, -2.0], vector![3.0, 1.0]);
/// let differences = linearize_by_differences(&arm, &q, &qd, &u, 1e-5)?;
/// let exact = linearize(&arm, &q, &qd, &u)?;
/// assert!((differences.by_position - exact.by_position).norm() < 1e-7);
/// assert!((differences.by_velocity - exact.by_velocity).norm() < 1e-7);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// If [`Dynamics::try_forward`] fails at one of the displaced states.
///
/// # Panics
/// If `step` is not positive and finite.
pub fn linearize_by_differences<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    step: f64,
) -> Result<Linearization<N>, IntegratorError> {
    assert!(step > 0.0 && step.is_finite(), "the difference step must be positive and finite, got {step}");
    system.try_forward(q, qd, u)?;
    Ok(Linearization {
        by_position: central_difference(q, step, |q| system.try_forward(q, qd, u))?,
        by_velocity: central_difference(qd, step, |qd| system.try_forward(q, qd, u))?,
        by_force: solve_columns(&system.mass(q), &SMatrix::identity())?,
    })
}

/// Column k is (f(x + h eₖ) − f(x − h eₖ)) / 2h, with the actual 2h after rounding.
fn central_difference<const N: usize>(
    x: &SVector<f64, N>,
    step: f64,
    f: impl Fn(&SVector<f64, N>) -> Result<SVector<f64, N>, IntegratorError>,
) -> Result<SMatrix<f64, N, N>, IntegratorError> {
    let mut jacobian = SMatrix::<f64, N, N>::zeros();
    for k in 0..N {
        let (mut forward, mut backward) = (*x, *x);
        forward[k] += step;
        backward[k] -= step;
        jacobian.set_column(k, &((f(&forward)? - f(&backward)?) / (forward[k] - backward[k])));
    }
    Ok(jacobian)
}

/// M⁻¹ B, column by column.
fn solve_columns<const N: usize>(
    mass: &SMatrix<f64, N, N>,
    right: &SMatrix<f64, N, N>,
) -> Result<SMatrix<f64, N, N>, IntegratorError> {
    let mut solution = *right;
    for k in 0..N {
        solution.set_column(k, &solve_mass(mass, &right.column(k).into_owned())?);
    }
    Ok(solution)
}
