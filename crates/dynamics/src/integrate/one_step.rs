//! The explicit steps: Euler's, the semi-implicit Euler's, and the classical Runge–Kutta's.

use nalgebra::SVector;

use crate::{Dynamics, DynamicsError};

/// A position and a velocity, (q, q̇) \[rad or m, per second\].
pub type State<const N: usize> = (SVector<f64, N>, SVector<f64, N>);

/// Refuses a step that is not a positive finite number of seconds: a mistake in the calling program.
#[track_caller]
pub(crate) fn assert_step(h: f64) {
    assert!(h > 0.0 && h.is_finite(), "the step must be positive and finite, got {h} s");
}

/// One explicit Euler step: q₁ = q₀ + h q̇₀, q̇₁ = q̇₀ + h q̈(q₀, q̇₀). The bad example. **(HLW §I.1.2)**
///
/// Order 1; it feeds energy into every oscillation.
///
/// # Errors
/// Where [`Dynamics::try_forward`] gives one.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
pub fn explicit_euler_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, DynamicsError> {
    assert_step(h);
    let qdd = system.try_forward(q, qd, u)?;
    Ok((q + qd * h, qd + qdd * h))
}

/// One semi-implicit Euler step: q̇₁ = q̇₀ + h q̈(q₀, q̇₀), q₁ = q₀ + h q̇₁. **(HLW §I.1.2)**
///
/// Order 1. Where M is constant and b = 0 it is the symplectic Euler method, whose energy error stays
/// bounded; where M varies it is not symplectic, since it steps q̇ and not p = M q̇.
///
/// # Errors
/// Where [`Dynamics::try_forward`] gives one.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
pub fn semi_implicit_euler_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, DynamicsError> {
    assert_step(h);
    let qd_next = qd + system.try_forward(q, qd, u)? * h;
    Ok((q + qd_next * h, qd_next))
}

/// One step of the classical Runge–Kutta method, order 4, u held over the step. **(HLW §II.1.1)**
///
/// k₁ at the start, k₂ and k₃ at the middle, k₄ at the end; x₁ = x₀ + h (k₁ + 2k₂ + 2k₃ + k₄)/6 with
/// x = (q, q̇).
///
/// # Errors
/// Where [`Dynamics::try_forward`] gives one, at any of the four stages.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{Reach2R, rk4_step};
/// use nalgebra::{vector, Vector2};
/// // On a flat table a stretched arm spinning as one body goes round and round.
/// let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0);
/// let (q, qd) = rk4_step(&arm, &vector![0.0, 0.0], &vector![1.0, 0.0], &Vector2::zeros(), 0.01)?;
/// assert!((q[0] - 0.01).abs() < 1e-12 && (qd[0] - 1.0).abs() < 1e-12);
/// # Ok::<(), dynamics::DynamicsError>(())
/// ```
#[doc(alias = "Runge-Kutta")]
pub fn rk4_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, DynamicsError> {
    assert_step(h);
    let (v1, a1) = (*qd, system.try_forward(q, qd, u)?);
    let v2 = qd + a1 * (h / 2.0);
    let a2 = system.try_forward(&(q + v1 * (h / 2.0)), &v2, u)?;
    let v3 = qd + a2 * (h / 2.0);
    let a3 = system.try_forward(&(q + v2 * (h / 2.0)), &v3, u)?;
    let v4 = qd + a3 * h;
    let a4 = system.try_forward(&(q + v3 * h), &v4, u)?;
    Ok((q + (v1 + (v2 + v3) * 2.0 + v4) * (h / 6.0), qd + (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0)))
}
