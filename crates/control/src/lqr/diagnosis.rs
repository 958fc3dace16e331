//! Diagnosis of the mode for which a Riccati equation has no stabilizing solution.

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::error::DlqrError;

/// Squarings for the spectral radius: the exponent k of Mᵏ becomes 2⁶⁴.
const SQUARINGS: usize = 64;

/// Sweeps of the eigenvalue iteration per row; a few are usual.
const SWEEPS: usize = 100;

/// The eigenvalues; `None` if their iteration does not converge, which can happen for multiple eigenvalues.
fn eigenvalues(m: &DMatrix<f64>) -> Option<DVector<Complex<f64>>> {
    let to = |accuracy| Schur::try_new(m.clone(), accuracy, SWEEPS * m.nrows());
    let schur = [f64::EPSILON, 1e-14, 1e-12].into_iter().find_map(to)?;
    Some(schur.complex_eigenvalues())
}

/// The largest |λ| = lim ‖Mᵏ‖^(1/k), by squaring. It does not use eigenvalues, whose iteration may not
/// converge.
pub(super) fn spectral_radius(m: &DMatrix<f64>) -> f64 {
    let (mut power, mut logarithm, mut share) = (m.clone(), 0.0, 1.0);
    for _ in 0..SQUARINGS {
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

/// A mode that does not decay and is not stabilizable by B or not detectable by Q. The test of Popov,
/// Belevitch and Hautus finds it: [A − λ1, B] or [A − λ1; Q] loses rank.
pub(super) fn cause(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>) -> DlqrError {
    // Both are the rank of [A − λ1, X], with A or Aᵀ.
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
    // Scale X to the magnitude of A, so that neither is within the rounding of the other.
    let scale = if x.amax() > 0.0 { a.amax().max(1.0) / x.amax() } else { 0.0 };
    // A k-fold eigenvalue is accurate to ε^(1/k), or 1e-8 for the double eigenvalues of a robot's rigid
    // modes.
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
