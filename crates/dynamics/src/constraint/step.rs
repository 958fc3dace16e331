//! A time step that stays on the constraint.

use nalgebra::SVector;
use robot_dynamics_integrators::{Integrator, StepScheme};

use super::Pfaffian;
use super::error::ConstraintError;
use super::kkt::constrained_forward_dynamics;
use super::row_factor::RowFactor;
use crate::Dynamics;
use crate::integration::explicit_stages::explicit_step;

/// The state after a constrained step, and the correction of the projection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedStep<const K: usize, const N: usize> {
    /// q at the end of the step \[m or rad\].
    pub q: SVector<f64, N>,
    /// q̇ at the end of the step, projected \[m/s or rad/s\].
    pub qd: SVector<f64, N>,
    /// A q̇ at the end of the step before the projection: the drift of this step.
    pub drift: SVector<f64, K>,
    /// The kinetic energy that the projection removes, ½ nᵀM n ≥ 0 with n = (1−P) q̇ \[J\].
    pub energy_removed: f64,
}

/// One classical Runge–Kutta step of the constrained motion with u held, then q̇ ← P q̇.
///
/// The constrained acceleration keeps A q̇ = 0 exactly in continuous time; the step violates it by its own
/// error, O(h⁵). Projecting with P removes n = (1−P) q̇ = O(h⁵). P q̇ and n are orthogonal in M, so the
/// kinetic energy changes by exactly −½ nᵀM n = O(h¹⁰). That is far below the O(h⁵) energy error of the step,
/// and it never increases the energy. After the projection A q̇ is zero to rounding.
///
/// A holonomic constraint φ(q) = 0 enters by its rows A = ∂φ/∂q. Its velocity is zero to rounding, its
/// position φ to the order of the method, h⁴.
///
/// # Errors
/// As [`constrained_forward_dynamics`], at any of the four stages.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{KnifeEdge, Pfaffian, constrained_rk4_step};
/// use nalgebra::{Vector3, vector};
/// let rusty = KnifeEdge::new(2.0, 0.5);
/// let q = vector![0.0, 0.0, 0.4];
/// let qd = KnifeEdge::velocity(&q, 1.5, 0.8);
/// let step = constrained_rk4_step(&rusty.body, &rusty, &q, &qd, &Vector3::zeros(), 0.01)?;
/// assert!((rusty.rows(&step.q) * step.qd).norm() < 1e-15);
/// # Ok::<(), dynamics::ConstraintError>(())
/// ```
#[track_caller]
pub fn constrained_rk4_step<D, C, const K: usize, const N: usize>(
    system: &D,
    constraint: &C,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<ConstrainedStep<K, N>, ConstraintError>
where
    D: Dynamics<N> + ?Sized,
    C: Pfaffian<K, N> + ?Sized,
{
    let StepScheme::Explicit(stages) = Integrator::RungeKutta4.scheme() else {
        unreachable!("Runge–Kutta has explicit stages")
    };
    let (q_end, qd_end) = explicit_step(stages, q, qd, h, |q, qd| {
        let (rows, rate) = (constraint.rows(q), constraint.rows_rate(q, qd));
        constrained_forward_dynamics(system, q, qd, u, &rows, &rate).map(|(qdd, _)| qdd)
    })?;

    let (mass, rows) = (system.mass(&q_end), constraint.rows(&q_end));
    let allowed = RowFactor::new(&mass, &rows)?.project_velocity(&qd_end);
    let removed = qd_end - allowed;
    Ok(ConstrainedStep {
        q: q_end,
        qd: allowed,
        drift: rows * qd_end,
        energy_removed: 0.5 * removed.dot(&(mass * removed)),
    })
}
