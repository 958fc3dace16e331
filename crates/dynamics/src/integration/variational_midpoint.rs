//! Structure-preserving steps: the variational midpoint rule and its composition of order 4.
//!
//! Hamilton's principle is discretised before it is applied: the action of one step is L_d(q₀,q₁) = h
//! L((q₀+q₁)/2, (q₁−q₀)/h). Then p₀ = −D₁L_d and p₁ = D₂L_d define a map (q₀,p₀) → (q₁,p₁), which is
//! symplectic for every M(q) because a discrete action generates it. **(HLW §VI.6)** The map is the implicit
//! midpoint rule in (q, p). Backward error analysis bounds the energy error over exponentially long times
//! **(HLW §IX.8)**, and the momentum of a cyclic coordinate is conserved to round-off.

use nalgebra::SVector;
use robot_dynamics_integrators::{Integrator, IntegratorError, StepScheme};

use super::explicit_stages::{State, assert_step};
use robot_dynamics_number::check_finite;

use crate::{Dynamics, solve_mass};

/// The maximal number of iterations of an implicit step. Each gains a factor of about h·(rates of the
/// motion), so that a useful step needs fewer than ten.
const MAX_ITERATIONS: usize = 100;

/// One step of the variational midpoint rule: order 2, symplectic, reversible. **(HLW §VI.6)**
///
/// With v = (q₁−q₀)/h and the midpoint q_m = q₀ + h v/2 the force at the midpoint is F = ∂K/∂q − g + u − b.
/// Here ∂K/∂q = C(q_m,v)ᵀv for the Christoffel C. The equation is solved for v:
///
/// M(q_m) v = p₀ + (h/2) F(q_m, v),   q₁ = q₀ + h v,   p₁ = p₀ + h F,   p = M q̇.
///
/// Fixed-point iteration solves the equation to round-off; it converges if h is short relative to the time
/// constants of the motion.
///
/// # Errors
/// [`IntegratorError::NotConverged`] if the step is too long for the iteration;
/// [`IntegratorError::Input`] if an input is not finite; [`IntegratorError::SingularMass`].
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{Dynamics, Reach2R, variational_midpoint_step};
/// use nalgebra::{Vector2, vector};
/// // On a flat table nothing depends on q1, so its momentum cannot change.
/// let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0);
/// let (mut q, mut qd) = (vector![0.3, 1.2], vector![2.0, -5.0]);
/// let momentum = (arm.mass(&q) * qd)[0];
/// for _ in 0..100 {
///     (q, qd) = variational_midpoint_step(&arm, &q, &qd, &Vector2::zeros(), 0.02)?;
/// }
/// assert!(((arm.mass(&q) * qd)[0] - momentum).abs() < 1e-13);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
#[doc(alias = "implicit midpoint")]
#[track_caller]
pub fn variational_midpoint_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    row_step(Integrator::VariationalMidpoint, system, q, qd, u, h)
}

/// The variational midpoint rule composed with itself: order 4, symplectic, reversible. **(HLW §II.4)**
///
/// Three midpoint steps of γ₁h, γ₀h, γ₁h with γ₁ = 1/(2 − 2^{1/3}) ≈ 1.35 and γ₀ = 1 − 2γ₁ ≈ −1.70, which
/// cancel the third-order error. The longest inner step is 1.7 h; the middle one goes backwards.
///
/// ```
/// use dynamics::{Reach2R, variational_yoshida4_step};
/// use nalgebra::{Vector2, vector};
/// // There and, with the velocity turned round, back: the step is its own inverse.
/// let (arm, u) = (Reach2R::worked_example(), Vector2::zeros());
/// let (q0, qd0) = (vector![0.3, 1.2], vector![1.0, -2.0]);
/// let (q1, qd1) = variational_yoshida4_step(&arm, &q0, &qd0, &u, 0.01)?;
/// let (q2, qd2) = variational_yoshida4_step(&arm, &q1, &-qd1, &u, 0.01)?;
/// assert!((q2 - q0).norm() < 1e-13 && (qd2 + qd0).norm() < 1e-12);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// As for [`variational_midpoint_step`].
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
#[doc(alias = "Yoshida")]
#[doc(alias = "triple jump")]
#[track_caller]
pub fn variational_yoshida4_step<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    row_step(Integrator::VariationalYoshida4, system, q, qd, u, h)
}

/// One step of a method that composes midpoint steps.
#[track_caller]
fn row_step<D: Dynamics<N> + ?Sized, const N: usize>(
    row: Integrator,
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<State<N>, IntegratorError> {
    let StepScheme::Variational(fractions) = row.scheme() else { unreachable!("{row} composes midpoints") };
    compose(system, q, qd, u, h, fractions)
}

/// Midpoint steps of the given fractions of h, from (q, q̇) to (q, q̇) through (q, p).
#[track_caller]
pub(super) fn compose<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
    fractions: &[f64],
) -> Result<State<N>, IntegratorError> {
    assert_step(h);
    check_finite("q", q.as_slice())?;
    check_finite("qd", qd.as_slice())?;
    check_finite("u", u.as_slice())?;
    let (mut q, mut velocity) = (*q, *qd);
    let mut p = system.mass(&q) * qd;
    for fraction in fractions {
        let part = fraction * h;
        velocity = mean_velocity(system, &q, &p, &velocity, u, part)?;
        p += force(system, &(q + velocity * (part / 2.0)), &velocity, u) * part;
        q += velocity * part;
    }
    Ok((q, solve_mass(&system.mass(&q), &p)?))
}

/// F = ∂L/∂q + u − b at position q and velocity v.
///
/// (∂K/∂q)ₖ = ½ vᵀ(∂M/∂qₖ)v = (Cᵀv)ₖ: two of the three terms of the Christoffel symbols cancel. No difference
/// quotient is used.
fn force<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    v: &SVector<f64, N>,
    u: &SVector<f64, N>,
) -> SVector<f64, N> {
    system.coriolis_matrix(q, v).tr_mul(v) - system.gravity(q) + u - system.dissipation(q, v)
}

/// The v that solves M(q_m) v = p₀ + (h/2) F(q_m, v), q_m = q₀ + (h/2) v; h may be negative.
fn mean_velocity<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    p: &SVector<f64, N>,
    guess: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<SVector<f64, N>, IntegratorError> {
    let mut v = *guess;
    let mut last_change = f64::INFINITY;
    for iterations in 1..=MAX_ITERATIONS {
        let middle = q + v * (h / 2.0);
        let right = p + force(system, &middle, &v, u) * (h / 2.0);
        // A diverging iteration ends in infinities: the step is too long, the model is valid.
        if !right.iter().all(|x| x.is_finite()) {
            return Err(IntegratorError::NotConverged { residual: f64::INFINITY, iterations, step: h });
        }
        let next = solve_mass(&system.mass(&middle), &right)?;
        let change = (next - v).amax();
        v = next;
        // The changes shrink until they reach round-off. When they stop shrinking, check that the residual is
        // at round-off.
        if change == 0.0
            || (change >= last_change
                && change <= 1e3 * f64::EPSILON * rounding_scale(system, q, p, guess, u, h)?)
        {
            return Ok(v);
        }
        last_change = change;
    }
    let scale = rounding_scale(system, q, p, guess, u, h)?;
    Err(IntegratorError::NotConverged { residual: last_change / scale, iterations: MAX_ITERATIONS, step: h })
}

/// The size of the terms whose sum is v: rounding leaves ε of it, even if the terms cancel. The factor 1 +
/// |q| is for joints that have turned many times: q is accurate to ε|q|, and so is M(q).
///
/// It is computed at the start of the step, because a diverging iterate would loosen its own tolerance.
fn rounding_scale<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q: &SVector<f64, N>,
    p: &SVector<f64, N>,
    guess: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
) -> Result<f64, IntegratorError> {
    let mass = system.mass(q);
    let half = h / 2.0;
    let mut scale = guess.amax();
    for term in [*p, u * half, system.gravity(q) * half, system.dissipation(q, guess) * half] {
        scale = scale.max(solve_mass(&mass, &term)?.amax());
    }
    Ok(scale * (1.0 + q.amax()))
}
