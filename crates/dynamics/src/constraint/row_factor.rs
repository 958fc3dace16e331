//! The constraint rows made orthonormal in the metric M⁻¹: A = T E with E M⁻¹ Eᵀ = 1.

use nalgebra::{SMatrix, SVector};

use super::error::{ConstraintError, DependentRow};
use super::mass_factor::MassFactor;

/// A row is dependent if its part independent of the earlier rows is below this fraction of its length.
///
/// Lengths are measured in M⁻¹, so neither the scale of a row nor the unit of a coordinate matters. Rounding
/// leaves about ε√κ(M) of a dependent row, which is 1e-10 at κ(M) = 1e11. Rows as nearly parallel as that
/// amplify the error of λ by 1e10, so that λ has fewer than six digits.
const DEPENDENCE: f64 = 1e-10;

/// A = T E with T lower triangular (K×K) and the rows of E orthonormal in M⁻¹: E M⁻¹ Eᵀ = 1.
///
/// Then A M⁻¹ Aᵀ = T Tᵀ, but the product is never formed: its condition number is the square of T's.
/// Gram–Schmidt is run twice on every row, which leaves E orthonormal to rounding.
/// Source: Golub, Van Loan, *Matrix Computations* (2013), ch. 5.2.
#[derive(Clone, Debug, PartialEq)]
pub struct RowFactor<const K: usize, const N: usize> {
    /// T.
    pub(crate) triangle: SMatrix<f64, K, K>,
    /// E: row k is a force direction of unit length in M⁻¹.
    pub(crate) forces: SMatrix<f64, K, N>,
    /// (M⁻¹Eᵀ)ᵀ: row k is the acceleration that force k causes.
    pub(crate) responses: SMatrix<f64, K, N>,
}

impl<const K: usize, const N: usize> RowFactor<K, N> {
    /// Factors A (K×N) in the metric of the mass matrix M (N×N).
    ///
    /// # Errors
    /// [`ConstraintError::NonFiniteRow`]; [`ConstraintError::Dynamics`] if M is singular;
    /// [`ConstraintError::DependentRows`] names each row that is a combination of earlier ones.
    pub fn new(mass: &SMatrix<f64, N, N>, rows: &SMatrix<f64, K, N>) -> Result<Self, ConstraintError> {
        Self::from_mass_factor(&MassFactor::new(mass)?, rows)
    }

    pub(crate) fn from_mass_factor(
        mass: &MassFactor<N>,
        rows: &SMatrix<f64, K, N>,
    ) -> Result<Self, ConstraintError> {
        check_rows("A", rows)?;
        let mut factor =
            Self { triangle: SMatrix::zeros(), forces: SMatrix::zeros(), responses: SMatrix::zeros() };
        let mut dependent = Vec::new();
        for i in 0..K {
            // Entries of size 1: otherwise the squares of a row of 1e200 or 1e-200 exceed the range of f64.
            let largest = rows.row(i).amax();
            let scale = if largest > 0.0 { largest } else { 1.0 };
            let row = rows.row(i).transpose() / scale;
            let length = row.dot(&mass.solve(&row)).sqrt();
            let mut rest = row;
            for _pass in 0..2 {
                for j in 0..i {
                    // Component along e_j in the metric M⁻¹: e_jᵀM⁻¹ r. A dependent row j left e_j = 0.
                    let component = factor.responses.row(j).transpose().dot(&rest);
                    factor.triangle[(i, j)] += component;
                    rest -= factor.forces.row(j).transpose() * component;
                }
            }
            let response = mass.solve(&rest);
            let remainder = rest.dot(&response).sqrt();
            if remainder > DEPENDENCE * length {
                factor.triangle[(i, i)] = remainder;
                factor.forces.set_row(i, &(rest / remainder).transpose());
                factor.responses.set_row(i, &(response / remainder).transpose());
            } else {
                dependent.push(DependentRow { row: i, combination_of: factor.combination(i, length) });
            }
            for j in 0..=i {
                factor.triangle[(i, j)] *= scale;
            }
        }
        if dependent.is_empty() {
            Ok(factor)
        } else {
            Err(ConstraintError::DependentRows { rank: K - dependent.len(), rows: dependent })
        }
    }

    /// The earlier rows with a coefficient in row i = Σ cⱼ row j: Tᵀ c = T row i, by back substitution.
    fn combination(&self, i: usize, length: f64) -> Vec<usize> {
        let t = &self.triangle;
        let mut coefficient = [0.0; K];
        for j in (0..i).rev().filter(|&j| t[(j, j)] > 0.0) {
            let later: f64 = (j + 1..i).map(|k| coefficient[k] * t[(k, j)]).sum();
            coefficient[j] = (t[(i, j)] - later) / t[(j, j)];
        }
        let row_size = |j: usize| (0..=j).fold(0.0, |size: f64, k| size.max(t[(j, k)].abs()));
        (0..i).filter(|&j| (coefficient[j] * row_size(j)).abs() > DEPENDENCE * length).collect()
    }

    /// x of T x = y.
    pub(crate) fn solve_triangle(&self, y: &SVector<f64, K>) -> SVector<f64, K> {
        let mut x = *y;
        for i in 0..K {
            for k in 0..i {
                x[i] -= self.triangle[(i, k)] * x[k];
            }
            x[i] /= self.triangle[(i, i)];
        }
        x
    }

    /// x of Tᵀ x = y.
    pub(crate) fn solve_triangle_transposed(&self, y: &SVector<f64, K>) -> SVector<f64, K> {
        let mut x = *y;
        for i in (0..K).rev() {
            for k in i + 1..K {
                x[i] -= self.triangle[(k, i)] * x[k];
            }
            x[i] /= self.triangle[(i, i)];
        }
        x
    }

    /// P v = v − M⁻¹Eᵀ E v: of the velocities that the rows allow, the one nearest to v in kinetic energy.
    /// **(PRM 10.19)**
    ///
    /// The subtraction runs twice: the second pass removes the rounding of the first.
    pub fn project_velocity(&self, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let once = qd - self.responses.transpose() * (self.forces * qd);
        once - self.responses.transpose() * (self.forces * once)
    }
}

/// Rejects a row matrix with a NaN or an infinity.
pub(crate) fn check_rows<const K: usize, const N: usize>(
    matrix: &'static str,
    rows: &SMatrix<f64, K, N>,
) -> Result<(), ConstraintError> {
    match rows.iter().position(|x| !x.is_finite()) {
        // The storage is column-major.
        Some(entry) => Err(ConstraintError::NonFiniteRow { matrix, row: entry % K, column: entry / K }),
        None => Ok(()),
    }
}
