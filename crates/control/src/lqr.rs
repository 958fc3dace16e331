//! The infinite-horizon linear-quadratic regulator in discrete time: u = −K x minimizes Σ (xᵀQx + uᵀRu) along
//! x ← A x + B u.
//!
//! P = Q + AᵀP A − AᵀP B (R + BᵀP B)⁻¹BᵀP A by structure-preserving doubling, then Newton's method (Hewer
//! 1971). Cost: O(n³) for each of some dozens of doublings.
//!
//! K belongs to one length of step. A growing mode that B cannot move or Q does not penalize is an error.
//! Source: Chu, Fan, Lin, Wang, *Structure-preserving algorithms for periodic discrete-time algebraic Riccati
//! equations*, Int. J. Control 77 (2004).

mod diagnosis;
mod error;

pub use error::DlqrError;

use nalgebra::{Cholesky, DMatrix};

use self::diagnosis::{cause, spectral_radius};
use self::error::check_matrices;

/// Each doubling covers twice as many steps as the one before: 2⁶⁴ in total.
const MOST_DOUBLINGS: usize = 64;

/// The error converges quadratically in Newton's method; more than a few steps mean that only rounding is
/// left.
const MOST_REFINEMENTS: usize = 20;

/// The relative change of P in the last refinement that counts as rounding.
const ROUNDING: f64 = 1e-8;

/// The feedback u = −K x that minimizes the cost of all future steps, from [`dlqr`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Dlqr {
    /// K, m×n.
    pub gain: DMatrix<f64>,
    /// P, n×n, symmetric and positive semidefinite: x₀ᵀ P x₀ is the minimal cost from x₀.
    pub cost: DMatrix<f64>,
    /// The largest |λ| of A − B K, below 1: the asymptotic decay of x per step.
    pub spectral_radius: f64,
}

/// The gain K of u = −K x that minimizes Σ (xₖᵀQ xₖ + uₖᵀR uₖ) along xₖ₊₁ = A xₖ + B uₖ.
///
/// A is n×n, B n×m, Q n×n, R m×m. Q is symmetric and positive semidefinite, R symmetric and positive
/// definite. P is the stabilizing solution of the discrete algebraic Riccati equation, and K follows from it:
///
/// > P = Q + AᵀP A − AᵀP B (R + BᵀP B)⁻¹ BᵀP A,  K = (R + BᵀP B)⁻¹ BᵀP A
///
/// The structure-preserving doubling algorithm computes P. Its k-th step is the value of 2ᵏ steps. It starts
/// with A, G = B R⁻¹Bᵀ, H = Q, and H → P quadratically:
///
/// > W = 1 + G H,  A ← A W⁻¹A,  G ← G + A W⁻¹G Aᵀ,  H ← H + AᵀH W⁻¹A
///
/// If B R⁻¹Bᵀ is large, W⁻¹ loses digits, so Newton's method follows. It alternates between the cost of K, P
/// = Σ (A−BK)ᵀᵏ(Q + KᵀR K)(A−BK)ᵏ, and K from P, until P converges. The cost is O(n³) per doubling, with some
/// dozens in total.
///
/// The solution exists if B can move, and Q penalizes, every mode of A with |λ| ≥ 1. A growing mode without a
/// cost is an error, because the optimum would not stabilize it.
///
/// Sources: Chu, Fan, Lin, Wang, *Structure-preserving algorithms for periodic discrete-time algebraic
/// Riccati equations*, Int. J. Control 77 (2004); Hewer, *An iterative technique for the computation of the
/// steady state gains for the discrete optimal regulator*, IEEE Trans. Automatic Control 16 (1971).
///
/// For a robot, A and B are those of `linearize_step` about a state (q\*, v\*) held by τ\*. Then x is (q ⊖
/// q\*, v − v\*), with 2nv numbers even if q has quaternions, and τ = τ\* − K x. K depends on the length of
/// the step.
///
/// ```
/// use nalgebra::dmatrix;
/// use robot_dynamics::control::dlqr;
/// // Push a mass of 1 kg with a force that is held for 0.1 s.
/// let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
/// let found = dlqr(&a, &b, &dmatrix![1.0, 0.0; 0.0, 0.1], &dmatrix![0.01])?;
/// let mut x = dmatrix![1.0; 0.0];
/// for _ in 0..100 {
///     x = &a * &x - &b * (&found.gain * &x);
/// }
/// assert!(x.norm() < 1e-9 && found.spectral_radius < 0.8);
/// # Ok::<(), robot_dynamics::control::DlqrError>(())
/// ```
///
/// # Errors
/// [`DlqrError`] if
/// - a matrix has the wrong shape, or is not finite, not symmetric or not (semi)definite, with the entry or
///   the eigenvalue;
/// - a mode of A is not stabilizable by B or not detectable by Q, with its eigenvalue;
/// - the iteration does not converge.
#[doc(alias = "dare")]
#[doc(alias = "Riccati")]
pub fn dlqr(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Dlqr, DlqrError> {
    let effort = check_matrices(a, b, q, r)?;
    let (q, r) = (symmetric(q), symmetric(r));
    let found = riccati(a, b, &q, &effort).and_then(|cost| refined(a, b, &q, &r, cost));
    found.ok_or_else(|| cause(a, b, &q))
}

/// P by doubling; `None` without convergence.
fn riccati(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    effort: &Cholesky<f64, nalgebra::Dyn>,
) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let mut transition = a.clone();
    let mut reach = symmetric(&(b * effort.solve(&b.transpose())));
    let mut cost = q.clone();
    for _ in 0..MOST_DOUBLINGS {
        let coupling = DMatrix::identity(n, n) + &reach * &cost;
        // W⁻¹ [A, G] by one factorization.
        let factor = coupling.lu();
        let (onward, spread) = (factor.solve(&transition)?, factor.solve(&reach)?);
        let more = transition.transpose() * &cost * &onward;
        let further = &transition * spread * transition.transpose();
        transition = &transition * &onward;
        reach = symmetric(&(reach + further));
        cost = symmetric(&(cost + &more));
        let size = cost.norm();
        if !size.is_finite() || !reach.norm().is_finite() || !transition.norm().is_finite() {
            return None;
        }
        // The next change is about the square of this one, and below the rounding of H.
        if more.norm() <= f64::EPSILON * size {
            return Some(cost);
        }
    }
    None
}

/// Newton's method, which alternates between K from P and P as the cost of K, until P converges. `None` if A
/// − B K is not stable or P does not converge.
fn refined(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    mut cost: DMatrix<f64>,
) -> Option<Dlqr> {
    let mut last = f64::INFINITY;
    for _ in 0..MOST_REFINEMENTS {
        let gain = greedy(a, b, r, &cost)?;
        let next = cost_of(&(a - b * &gain), &(q + gain.transpose() * r * &gain))?;
        let size = next.norm();
        let change = if size > 0.0 { (&next - &cost).norm() / size } else { 0.0 };
        cost = next;
        // The change converges quadratically until only rounding is left.
        if change <= f64::EPSILON || (change <= ROUNDING && change > 0.25 * last) {
            let gain = greedy(a, b, r, &cost)?;
            let spectral_radius = spectral_radius(&(a - b * &gain));
            return (spectral_radius < 1.0).then_some(Dlqr { gain, cost, spectral_radius });
        }
        last = change;
    }
    None
}

/// (R + BᵀP B)⁻¹BᵀP A: the optimal gain now if P is the cost of all later steps.
fn greedy(a: &DMatrix<f64>, b: &DMatrix<f64>, r: &DMatrix<f64>, cost: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let weighed = b.transpose() * cost;
    Some(symmetric(&(r + &weighed * b)).cholesky()?.solve(&(weighed * a)))
}

/// X = Σ Fᵀᵏ S Fᵏ by doubling, X ← X + FᵀX F, F ← F²; `None` if the sum diverges.
fn cost_of(closed: &DMatrix<f64>, stage: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (mut power, mut sum) = (closed.clone(), symmetric(stage));
    for _ in 0..MOST_DOUBLINGS {
        let more = power.transpose() * &sum * &power;
        sum = symmetric(&(sum + &more));
        power = &power * &power;
        let size = sum.norm();
        if !size.is_finite() || !power.norm().is_finite() {
            return None;
        }
        if more.norm() <= f64::EPSILON * size {
            return Some(sum);
        }
    }
    None
}

/// ½ (M + Mᵀ).
fn symmetric(m: &DMatrix<f64>) -> DMatrix<f64> {
    (m + m.transpose()) * 0.5
}
