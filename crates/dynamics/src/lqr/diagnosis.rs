//! Which mode keeps a Riccati equation from having a stabilising solution.

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::MOST_DOUBLINGS;
use super::error::DlqrError;

/// Sweeps of the eigenvalue iteration for each row; a handful are usual.
const SWEEPS: usize = 100;

/// The eigenvalues; none where their iteration does not converge, as it may not to the last digit for those that come
/// several times.
fn eigenvalues(m: &DMatrix<f64>) -> Option<DVector<Complex<f64>>> {
    let to = |accuracy| Schur::try_new(m.clone(), accuracy, SWEEPS * m.nrows());
    let schur = [f64::EPSILON, 1e-14, 1e-12].into_iter().find_map(to)?;
    Some(schur.complex_eigenvalues())
}

/// The largest |λ| = lim ‖Mᵏ‖^(1/k), by squaring: needs no eigenvalues, which may not converge.
pub(super) fn spectral_radius(m: &DMatrix<f64>) -> f64 {
    let (mut power, mut logarithm, mut share) = (m.clone(), 0.0, 1.0);
    for _ in 0..MOST_DOUBLINGS {
        let size = power.norm();
        if size == 0.0 {
            return 0.0;
        }
        logarithm += share * size.ln();
        share *= 0.5;
        power /= size;
        power = &power * &power;
    }
    logarithm.exp()
}

/// A mode that does not decay and that B does not move or Q does not see, by Popov, Belevitch and Hautus: where
/// [A − λ1, B] or [A − λ1; Q] loses rank.
pub(super) fn cause(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>) -> DlqrError {
    // Both as rank of [A − λ1, X], of A or of Aᵀ.
    let unmoved = lost_mode(a, b);
    let unseen = || lost_mode(&a.transpose(), &q.transpose());
    match unmoved {
        Some((modulus, angle)) => DlqrError::NotStabilizable { modulus, angle },
        None => match unseen() {
            Some((modulus, angle)) => DlqrError::NotDetectable { modulus, angle },
            None => DlqrError::NotConverged,
        },
    }
}

/// The eigenvalue with |λ| ≥ 1, as modulus and angle, at which [A − λ1, X] loses rank.
fn lost_mode(a: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<(f64, f64)> {
    let n = a.nrows();
    // X in A's size, so that neither drowns in the other's rounding.
    let scale = if x.amax() > 0.0 { a.amax().max(1.0) / x.amax() } else { 0.0 };
    // An eigenvalue that belongs to k equal ones is known to ε^(1/k); of two, a robot's rigid modes, to 1e-8.
    let (almost, lost) = (1.0 - 1e-7, 1e-7);
    eigenvalues(a)?.iter().find_map(|&eigenvalue| {
        if eigenvalue.norm() < almost {
            return None;
        }
        let pencil = DMatrix::from_fn(n, n + x.ncols(), |i, j| {
            if j >= n {
                return Complex::new(scale * x[(i, j - n)], 0.0);
            }
            let shift = if i == j { eigenvalue } else { Complex::new(0.0, 0.0) };
            Complex::new(a[(i, j)], 0.0) - shift
        });
        let singular = pencil.singular_values();
        (singular.min() <= lost * singular.max()).then(|| (eigenvalue.norm(), eigenvalue.arg().abs()))
    })
}
