//! The infinite-horizon linear-quadratic regulator in discrete time.

mod diagnosis;
mod error;

pub use error::DlqrError;

use nalgebra::{Cholesky, DMatrix};

use self::diagnosis::{cause, spectral_radius};
use self::error::check_matrices;

/// A step of a doubling covers twice the steps of the one before: 2⁶⁴ in all.
const MOST_DOUBLINGS: usize = 64;

/// Newton's steps square what is left of an error; more than a few mean that it is rounding.
const MOST_REFINEMENTS: usize = 20;

/// The relative change of P by the last of them that still counts as rounding.
const ROUNDING: f64 = 1e-8;

/// The feedback u = −K x that minimises the cost of all steps to come, as [`dlqr`] finds it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Dlqr {
    /// K, m×n.
    pub gain: DMatrix<f64>,
    /// P, n×n, symmetric and positive semidefinite: x₀ᵀ P x₀ is the least cost from x₀.
    pub cost: DMatrix<f64>,
    /// The largest |λ| of A − B K, below 1: what a step leaves of x in the long run.
    pub spectral_radius: f64,
}

/// The gain K of u = −K x that minimises Σ (xₖᵀQ xₖ + uₖᵀR uₖ) along xₖ₊₁ = A xₖ + B uₖ.
///
/// A is n×n, B n×m, Q n×n, R m×m; Q is symmetric and positive semidefinite, R symmetric and positive definite. P is
/// the stabilising solution of the discrete algebraic Riccati equation, and K follows from it:
///
/// > P = Q + AᵀP A − AᵀP B (R + BᵀP B)⁻¹ BᵀP A,  K = (R + BᵀP B)⁻¹ BᵀP A
///
/// It is found by the structure-preserving doubling algorithm, whose k-th step is the value of 2ᵏ steps:
/// W = 1 + G H, A ← A W⁻¹A, G ← G + A W⁻¹G Aᵀ, H ← H + AᵀH W⁻¹A from A, G = B R⁻¹Bᵀ, H = Q; H → P quadratically.
/// Where B R⁻¹Bᵀ is large W⁻¹ costs digits, so Newton's method follows: P = Σ (A−BK)ᵀᵏ(Q + KᵀR K)(A−BK)ᵏ, the cost of
/// K itself, and K of P, until P stays. O(n³) a doubling, some dozens in all. It is found where every mode of A with
/// |λ| ≥ 1 is moved by B and costs by Q; a growing mode without a cost is refused, as the cheapest is to let it go.
///
/// Sources: Chu, Fan, Lin, Wang, *Structure-preserving algorithms for periodic discrete-time algebraic Riccati
/// equations*, Int. J. Control 77 (2004); Hewer, *An iterative technique for the computation of the steady state gains
/// for the discrete optimal regulator*, IEEE Trans. Automatic Control 16 (1971).
///
/// For a robot, A and B are those of `linearize_step` about a state (q\*, v\*) held by τ\*: x is (q ⊖ q\*, v − v\*),
/// 2nv numbers also where q has quaternions, and τ = τ\* − K x. A step of another length has another K.
///
/// ```
/// use dynamics::dlqr;
/// use nalgebra::dmatrix;
/// // A mass of 1 kg pushed for 0.1 s at a time.
/// let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
/// let found = dlqr(&a, &b, &dmatrix![1.0, 0.0; 0.0, 0.1], &dmatrix![0.01])?;
/// let mut x = dmatrix![1.0; 0.0];
/// for _ in 0..100 {
///     x = &a * &x - &b * (&found.gain * &x);
/// }
/// assert!(x.norm() < 1e-9 && found.spectral_radius < 0.8);
/// # Ok::<(), dynamics::DlqrError>(())
/// ```
///
/// # Errors
/// [`DlqrError`]: a matrix of the wrong shape, not finite, not symmetric, or not (semi)definite, with the entry or the
/// eigenvalue at fault; a mode of A that B does not move or Q does not see, with its eigenvalue; no convergence.
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

/// P by doubling; none where it does not converge.
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
        // W⁻¹ [A, G] by one factorisation.
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
        // What is still to come is the square of what came: below the rounding of H.
        if more.norm() <= f64::EPSILON * size {
            return Some(cost);
        }
    }
    None
}

/// K of P, and of the P that is K's own cost, until P stays; none where A − B K is no contraction or P never stays.
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
        // Newton's change is squared each time until rounding is all that is left of it.
        if change <= f64::EPSILON || (change <= ROUNDING && change > 0.25 * last) {
            let gain = greedy(a, b, r, &cost)?;
            let spectral_radius = spectral_radius(&(a - b * &gain));
            return (spectral_radius < 1.0).then_some(Dlqr { gain, cost, spectral_radius });
        }
        last = change;
    }
    None
}

/// (R + BᵀP B)⁻¹BᵀP A: the best force now, where all later steps cost P.
fn greedy(a: &DMatrix<f64>, b: &DMatrix<f64>, r: &DMatrix<f64>, cost: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let weighed = b.transpose() * cost;
    Some(symmetric(&(r + &weighed * b)).cholesky()?.solve(&(weighed * a)))
}

/// X = Σ Fᵀᵏ S Fᵏ by doubling, X ← X + FᵀX F, F ← F²; none where the sum does not end.
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
