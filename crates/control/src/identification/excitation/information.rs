//! The information of rows W on the base parameters, and its derivative by the entries of W.

use nalgebra::DMatrix;

use super::options::ExcitationCriterion;

/// The value of the criterion, which is minimized, and its derivative by W.
///
/// Determinant: −ln det(WᵀW)/(2n), with the derivative −W (WᵀW)⁻¹/n. It is the mean logarithm of the standard
/// deviations. Condition: ln(σ₁/σₙ) of the columns w/|w|. With the singular vectors, dσ = uᵀ dŴ v; the part
/// of a column's derivative along the column itself changes only its length.
///
/// `None` if W has no full rank.
pub(super) fn information(
    rows: &DMatrix<f64>,
    criterion: ExcitationCriterion,
) -> Option<(f64, DMatrix<f64>)> {
    let n = rows.ncols() as f64;
    let lengths: Vec<f64> = rows.column_iter().map(|column| column.norm()).collect();
    if lengths.iter().any(|length| !(*length > 0.0 && length.is_finite())) {
        return None;
    }
    let mut scaled = rows.clone();
    for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let gram = scaled.tr_mul(&scaled);
    let (value, mut derivative) = match criterion {
        ExcitationCriterion::Determinant => {
            let factor = gram.cholesky()?;
            let pivots: f64 = factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum();
            let lengths: f64 = lengths.iter().map(|length| length.ln()).sum();
            let derivative = factor.solve(&scaled.transpose()).transpose() / -n;
            (-(pivots + lengths) / n, derivative)
        }
        ExcitationCriterion::Condition => {
            let eigen = gram.symmetric_eigen();
            let (largest, smallest) = (eigen.eigenvalues.imax(), eigen.eigenvalues.imin());
            let [most, least] = [largest, smallest].map(|i| eigen.eigenvalues[i]);
            if least <= 0.0 {
                return None;
            }
            // u vᵀ/σ = Ŵ v vᵀ/σ².
            let part = |i: usize| {
                let v = eigen.eigenvectors.column(i);
                &scaled * v * v.transpose() / eigen.eigenvalues[i]
            };
            let mut derivative = part(largest) - part(smallest);
            for (mut column, unit) in derivative.column_iter_mut().zip(scaled.column_iter()) {
                let along = unit.dot(&column);
                column.axpy(-along, &unit, 1.0);
            }
            (0.5 * (most / least).ln(), derivative)
        }
    };
    for (mut column, length) in derivative.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    Some((value, derivative))
}

/// The condition number of W with columns of unit length; infinite without full rank.
pub(super) fn condition(rows: &DMatrix<f64>) -> f64 {
    information(rows, ExcitationCriterion::Condition).map_or(f64::INFINITY, |(value, _)| value.exp())
}
