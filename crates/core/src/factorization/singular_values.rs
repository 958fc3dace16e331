//! Singular values and vectors by one-sided Jacobi rotations: B V = UΣ. Cost: O(m n²) per sweep, six to ten
//! sweeps.
//!
//! Small and nearly equal values are as accurate as others. Source: Golub, Van Loan, *Matrix Computations*
//! (2013), ch. 8.6.3.

use nalgebra::DMatrix;

/// B V = U Σ with V orthonormal: the columns of B V are orthogonal, and their lengths are the singular
/// values.
///
/// Rotations of pairs of columns make them orthogonal. Small and nearly equal singular values come out as
/// accurate as others. `nalgebra` computes values of the same accuracy, but its vectors of nearly equal
/// values have errors of up to 2e-5. Source: Golub, Van Loan, *Matrix Computations* (2013), ch. 8.6.3.
pub struct SingularValues {
    /// B V, m×n.
    pub product: DMatrix<f64>,
    /// V, n×n.
    pub right: DMatrix<f64>,
    /// Σ: the lengths of the columns of B V, unordered.
    pub values: Vec<f64>,
}

/// The largest number of sweeps over all pairs. Convergence is quadratic; six to ten sweeps are typical.
const MOST_SWEEPS: usize = 60;

impl SingularValues {
    pub fn of(b: &DMatrix<f64>) -> Self {
        let n = b.ncols();
        let (mut product, mut right) = (b.clone(), DMatrix::identity(n, n));
        // Columns shorter than this are rounding, and their directions are meaningless.
        let least = f64::EPSILON * b.norm();
        for _sweep in 0..MOST_SWEEPS {
            let mut rotated = false;
            for i in 0..n {
                for j in i + 1..n {
                    let (first, second) = (product.column(i).norm(), product.column(j).norm());
                    let along = product.column(i).dot(&product.column(j));
                    if along.abs() <= f64::EPSILON * first * second || first.max(second) <= least {
                        continue;
                    }
                    rotated = true;
                    let ratio = (second - first) * (second + first) / (2.0 * along);
                    let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
                    let cosine = 1.0 / tangent.hypot(1.0);
                    for matrix in [&mut product, &mut right] {
                        rotate(matrix, (i, j), cosine, cosine * tangent);
                    }
                }
            }
            if !rotated {
                break;
            }
        }
        let values = product.column_iter().map(|column| column.norm()).collect();
        Self { product, right, values }
    }
}

/// Columns i and j ← c xᵢ − s xⱼ and s xᵢ + c xⱼ.
fn rotate(matrix: &mut DMatrix<f64>, (i, j): (usize, usize), c: f64, s: f64) {
    for k in 0..matrix.nrows() {
        let (x, y) = (matrix[(k, i)], matrix[(k, j)]);
        matrix[(k, i)] = c * x - s * y;
        matrix[(k, j)] = s * x + c * y;
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// U Σ Vᵀ is B and V is orthonormal, for matrices with equal, small and zero singular values, built from
    /// two orthonormal matrices.
    #[test]
    fn factors_give_the_matrix_again() {
        let random = &mut SplitMix64::new(3);
        let orthonormal = |n: usize, random: &mut SplitMix64| {
            DMatrix::from_fn(n, n, |_, _| random.uniform(-1.0, 1.0)).qr().q()
        };
        for (m, n) in [(8, 6), (6, 8), (5, 5), (3, 1), (1, 3)] {
            let count = usize::min(m, n);
            for values in [[1.0; 5], [1.0, 1.0, 0.96, 1.0 - 1e-12, 0.5], [2.0, 2.0, 1e-8, 0.0, 0.0]] {
                let mut expected: Vec<f64> = values.iter().cycle().take(count).copied().collect();
                let mut sigma = DMatrix::zeros(m, n);
                (0..count).for_each(|k| sigma[(k, k)] = expected[k]);
                let b = orthonormal(m, random) * sigma * orthonormal(n, random);
                let found = SingularValues::of(&b);
                let one = found.right.tr_mul(&found.right) - DMatrix::<f64>::identity(n, n);
                assert!(one.amax() < 1e-14, "{one}");
                assert!((&found.product * found.right.transpose() - &b).amax() < 1e-14);
                let mut sorted = found.values;
                sorted.sort_by(|a, b| b.total_cmp(a));
                expected.sort_by(|a, b| b.total_cmp(a));
                expected.resize(n, 0.0);
                for (found, expected) in sorted.iter().zip(&expected) {
                    assert!((found - expected).abs() < 1e-14, "{sorted:?} {expected:?}");
                }
            }
        }
    }
}
