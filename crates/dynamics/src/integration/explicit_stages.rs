//! The explicit steps: Euler, semi-implicit Euler, and classical Runge–Kutta.

use nalgebra::SVector;
use robot_dynamics_integrators::{Integrator, IntegratorError, Stage, StepScheme};

use crate::Dynamics;

/// A position and a velocity, (q, q̇) \[rad or m, per second\].
pub type State<const N: usize> = (SVector<f64, N>, SVector<f64, N>);

/// Panics if the step is not positive and finite, a mistake in the calling program.
#[track_caller]
pub(crate) fn assert_step(h: f64) {
    assert!(h > 0.0 && h.is_finite(), "the step must be positive and finite, got {h} s");
}

/// One step of explicit stages from (q, q̇) under an acceleration q̈(q, q̇).
#[track_caller]
pub(crate) fn explicit_step<E, const N: usize>(
    stages: &[Stage],
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    h: f64,
    mut acceleration: impl FnMut(&SVector<f64, N>, &SVector<f64, N>) -> Result<SVector<f64, N>, E>,
) -> Result<State<N>, E> {
    assert_step(h);
    // Σ k x of the stages so far.
    let sum = |start: &SVector<f64, N>, weights: &[f64], rates: &[SVector<f64, N>]| {
        let mut sum = SVector::zeros();
        for (&k, rate) in weights.iter().zip(rates).filter(|(k, _)| **k != 0.0) {
            sum += rate * k;
        }
        start + sum * h
    };
    let (mut velocities, mut accelerations) =
        ([SVector::zeros(); Stage::MOST], [SVector::zeros(); Stage::MOST]);
    for (i, stage) in stages.iter().enumerate() {
        velocities[i] = sum(qd, stage.v_row, &accelerations);
        if Stage::needs_acceleration(stages, i) {
            accelerations[i] = acceleration(&sum(q, stage.q_row, &velocities), &velocities[i])?;
        }
    }
    let mut weights = ([0.0; Stage::MOST], [0.0; Stage::MOST]);
    for (i, stage) in stages.iter().enumerate() {
        (weights.0[i], weights.1[i]) = (stage.q_weight, stage.v_weight);
    }
    Ok((sum(q, &weights.0, &velocities), sum(qd, &weights.1, &accelerations)))
}

/// One step of a method with explicit stages.
#[track_caller]
fn row_step<D: Dynamics<N> + ?Sized, const N: usize>(
    row: Integrator,
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    let StepScheme::Explicit(stages) = row.scheme() else { unreachable!("{row} has explicit stages") };
    explicit_step(stages, q, qd, h, |q, qd| system.try_forward(q, qd, u))
}

/// One explicit Euler step: q₁ = q₀ + h q̇₀, q̇₁ = q̇₀ + h q̈(q₀, q̇₀). **(HLW §I.1.2)**
///
/// Order 1. Do not use it for simulation: it adds energy to every oscillation.
///
/// ```
/// use dynamics::{PlanarBody, explicit_euler_step};
/// use nalgebra::{Vector3, vector};
/// // A stone let go: after one step it is fast, but has not moved.
/// let stone = PlanarBody { m: 2.0, i_zz: 0.1, a_g: 9.81 };
/// let rest = Vector3::zeros();
/// let (q, qd) = explicit_euler_step(&stone, &rest, &rest, &rest, 0.1)?;
/// assert_eq!(q, rest);
/// assert!((qd - vector![0.0, -0.981, 0.0]).norm() < 1e-15);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// If [`Dynamics::try_forward`] fails.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
#[track_caller]
pub fn explicit_euler_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    row_step(Integrator::ExplicitEuler, system, q, qd, u, h)
}

/// One semi-implicit Euler step: q̇₁ = q̇₀ + h q̈(q₀, q̇₀), q₁ = q₀ + h q̇₁. **(HLW §I.1.2)**
///
/// Order 1. If M is constant and b = 0 it is the symplectic Euler method, whose energy error stays bounded.
/// If M varies it is not symplectic, since it steps q̇ and not p = M q̇.
///
/// ```
/// use dynamics::{PlanarBody, semi_implicit_euler_step};
/// use nalgebra::{Vector3, vector};
/// // A stone let go: it moves with the speed that it has at the end of the step.
/// let stone = PlanarBody { m: 2.0, i_zz: 0.1, a_g: 9.81 };
/// let rest = Vector3::zeros();
/// let (q, qd) = semi_implicit_euler_step(&stone, &rest, &rest, &rest, 0.1)?;
/// assert!((qd - vector![0.0, -0.981, 0.0]).norm() < 1e-15);
/// assert!((q - qd * 0.1).norm() < 1e-15);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// If [`Dynamics::try_forward`] fails.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
#[track_caller]
pub fn semi_implicit_euler_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    row_step(Integrator::SemiImplicitEuler, system, q, qd, u, h)
}

/// One step of the classical Runge–Kutta method of order 4, with u held over the step. **(HLW §II.1.1)**
///
/// k₁ at the start, k₂ and k₃ at the middle, k₄ at the end; x₁ = x₀ + h (k₁ + 2k₂ + 2k₃ + k₄)/6 with
/// x = (q, q̇).
///
/// # Errors
/// If [`Dynamics::try_forward`] fails at one of the four stages.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{Reach2R, rk4_step};
/// use nalgebra::{Vector2, vector};
/// // On a flat table a stretched arm spinning as one body goes round and round.
/// let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0);
/// let (q, qd) = rk4_step(&arm, &vector![0.0, 0.0], &vector![1.0, 0.0], &Vector2::zeros(), 0.01)?;
/// assert!((q[0] - 0.01).abs() < 1e-12 && (qd[0] - 1.0).abs() < 1e-12);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
#[doc(alias = "Runge-Kutta")]
#[track_caller]
pub fn rk4_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    row_step(Integrator::RungeKutta4, system, q, qd, u, h)
}
