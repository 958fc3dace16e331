//! Dense kernels on row-major matrices in memory of the caller: products, Cholesky factors, triangular
//! solves.

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

/// The rows and columns of a product that are summed in registers.
const ROWS: usize = 4;
const COLUMNS: usize = 8;

/// The entries of a product C += Aᵖ B that are computed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    All,
    /// At and below the diagonal, and some above it.
    Lower,
}

/// C += A B, with A of `inner` columns and B of `width` columns.
pub(crate) fn add_product(inner: usize, width: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    run_here(Product { a, strides: (inner, 1), inner, b, width, c, part: Part::All });
}

/// C += AᵀB, with A of `rows` columns and B of `width` columns.
pub(crate) fn add_transposed_product(rows: usize, width: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    let inner = a.len() / rows.max(1);
    run_here(Product { a, strides: (1, rows), inner, b, width, c, part: Part::All });
}

/// C += AᵀB for a symmetric C, of which only the entries at and below the diagonal are valid afterwards.
pub(crate) fn add_symmetric_product(n: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    let inner = a.len() / n.max(1);
    run_here(Product { a, strides: (1, n), inner, b, width: n, c, part: Part::Lower });
}

/// Copies the entries below the diagonal to those above it.
pub(crate) fn mirror_lower(n: usize, matrix: &mut [f64]) {
    for i in 0..n {
        for j in 0..i {
            matrix[j * n + i] = matrix[i * n + j];
        }
    }
}

struct Product<'a> {
    a: &'a [f64],
    /// The distances in `a` between rows, and between columns.
    strides: (usize, usize),
    inner: usize,
    b: &'a [f64],
    width: usize,
    c: &'a mut [f64],
    part: Part,
}

impl Call for Product<'_> {
    #[inline(always)]
    fn call<H: Hardware>(mut self) {
        if self.width == 0 || self.inner == 0 {
            return;
        }
        let width = self.width;
        let (eights, fours, twos) = (width - width % COLUMNS, width - width % 4, width - width % 2);
        (0..eights).step_by(COLUMNS).for_each(|column| self.columns::<COLUMNS>(column));
        (eights..fours).step_by(4).for_each(|column| self.columns::<4>(column));
        (fours..twos).step_by(2).for_each(|column| self.columns::<2>(column));
        (twos..width).for_each(|column| self.columns::<1>(column));
    }
}

impl Product<'_> {
    /// Adds some columns of the product.
    #[inline(always)]
    fn columns<const C: usize>(&mut self, column: usize) {
        let rows = self.c.len() / self.width;
        let first = if self.part == Part::Lower { column - column % ROWS } else { 0 };
        let fours = rows - rows % ROWS;
        (first..fours).step_by(ROWS).for_each(|row| self.tile::<ROWS, C>(row, column));
        (fours.max(first)..rows).for_each(|row| self.tile::<1, C>(row, column));
    }

    /// Adds R rows and C columns.
    #[inline(always)]
    fn tile<const R: usize, const C: usize>(&mut self, row: usize, column: usize) {
        let (width, (by_row, by_column)) = (self.width, self.strides);
        let mut sum = [[0.0; C]; R];
        for (k, b) in self.b.chunks_exact(width).enumerate().take(self.inner) {
            let b: &[f64; C] = b[column..].first_chunk().expect("columns within the matrix");
            let at = row * by_row + k * by_column;
            for (i, sum) in sum.iter_mut().enumerate() {
                let factor = self.a[at + i * by_row];
                sum.iter_mut().zip(b).for_each(|(sum, b)| *sum += factor * b);
            }
        }
        for (i, sum) in sum.iter().enumerate() {
            let to = &mut self.c[(row + i) * width + column..][..C];
            to.iter_mut().zip(sum).for_each(|(to, sum)| *to += sum);
        }
    }
}

/// `y` += A x, with A row-major.
pub(crate) fn add_matrix_vector(a: &[f64], x: &[f64], y: &mut [f64]) {
    if x.is_empty() {
        return;
    }
    for (y, row) in y.iter_mut().zip(a.chunks_exact(x.len())) {
        *y += dot(row, x);
    }
}

/// `y` += Aᵀx, with A row-major.
pub(crate) fn add_transposed_vector(a: &[f64], x: &[f64], y: &mut [f64]) {
    if y.is_empty() {
        return;
    }
    for (row, x) in a.chunks_exact(y.len()).zip(x) {
        y.iter_mut().zip(row).for_each(|(y, a)| *y += a * x);
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The sum of the absolute values.
pub(crate) fn sum_of_magnitudes(x: &[f64]) -> f64 {
    x.iter().map(|x| x.abs()).sum()
}

/// The largest absolute value; NaN if an entry is NaN.
pub(crate) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| if x.abs() <= most { most } else { x.abs() })
}

/// Replaces the lower half of a symmetric matrix by its Cholesky factor L; returns whether the matrix is
/// positive definite.
pub(crate) fn factorize(n: usize, matrix: &mut [f64]) -> bool {
    for j in 0..n {
        let (above, own) = matrix.split_at_mut(j * n);
        let own = &mut own[..n];
        for (k, row) in above.chunks_exact(n).enumerate() {
            own[k] = (own[k] - dot(&own[..k], &row[..k])) / row[k];
        }
        let pivot = own[j] - dot(&own[..j], &own[..j]);
        // False if the pivot is NaN.
        let is_positive = pivot > f64::EPSILON * own[j].abs();
        if !is_positive {
            return false;
        }
        own[j] = pivot.sqrt();
    }
    true
}

fn scale(factor: f64, x: &mut [f64]) {
    for x in x {
        *x *= factor;
    }
}

/// X ← (L Lᵀ)⁻¹X for X with n rows of `width` numbers.
pub(crate) fn solve_factored(n: usize, factor: &[f64], width: usize, x: &mut [f64]) {
    for i in 0..n {
        let (above, own) = x.split_at_mut(i * width);
        let own = &mut own[..width];
        for (k, row) in above.chunks_exact(width).enumerate() {
            let l = factor[i * n + k];
            own.iter_mut().zip(row).for_each(|(x, above)| *x -= l * above);
        }
        scale(1.0 / factor[i * n + i], own);
    }
    for i in (0..n).rev() {
        let (own, below) = x[i * width..].split_at_mut(width);
        for (k, row) in below.chunks_exact(width).enumerate().take(n - 1 - i) {
            let l = factor[(i + 1 + k) * n + i];
            own.iter_mut().zip(row).for_each(|(x, below)| *x -= l * below);
        }
        scale(1.0 / factor[i * n + i], own);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use robot_dynamics_number::SplitMix64;

    use super::*;

    fn rows(matrix: &DMatrix<f64>) -> Vec<f64> {
        matrix.transpose().as_slice().to_vec()
    }

    /// Sums of at most 23 products of numbers below 1, in another order: at most 23² roundings.
    const ROUNDING: f64 = 23.0 * 23.0 * f64::EPSILON;

    #[test]
    fn products_are_those_of_matrices() {
        let mut random = SplitMix64::new(5);
        for (m, k, n) in [(1, 1, 1), (2, 3, 4), (7, 14, 14), (14, 7, 15), (23, 18, 13), (5, 0, 3)] {
            let mut matrix =
                |rows, columns| DMatrix::from_fn(rows, columns, |_, _| random.uniform(-1.0, 1.0));
            let (a, b, c) = (matrix(m, k), matrix(k, n), matrix(m, n));
            let expected = rows(&(&c + &a * &b));
            let (mut by_rows, mut by_columns) = (rows(&c), rows(&c));
            add_product(k, n, &rows(&a), &rows(&b), &mut by_rows);
            add_transposed_product(m, n, a.as_slice(), &rows(&b), &mut by_columns);
            for (x, expected) in by_rows.iter().chain(&by_columns).zip(expected.iter().chain(&expected)) {
                assert!((x - expected).abs() <= ROUNDING, "{m} {k} {n}");
            }
            let mut gram = vec![0.0; n * n];
            add_symmetric_product(n, &rows(&b), &rows(&b), &mut gram);
            mirror_lower(n, &mut gram);
            let expected = rows(&(b.transpose() * &b));
            assert!(gram.iter().zip(&expected).all(|(x, y)| (x - y).abs() <= ROUNDING), "{k} {n}");
        }
    }

    /// The solution of a system with condition number below 1e3 loses three of sixteen digits.
    #[test]
    fn solutions_satisfy_their_equations() {
        let mut random = SplitMix64::new(6);
        for n in [1, 2, 5, 12] {
            let half = DMatrix::from_fn(n, n, |_, _| random.uniform(-1.0, 1.0));
            let matrix = &half * half.transpose() + DMatrix::identity(n, n);
            let x = DMatrix::from_fn(n, 3, |_, _| random.uniform(-1.0, 1.0));
            let (mut factor, mut solution) = (rows(&matrix), rows(&(&matrix * &x)));
            assert!(factorize(n, &mut factor));
            solve_factored(n, &factor, 3, &mut solution);
            assert!(solution.iter().zip(rows(&x)).all(|(found, x)| (found - x).abs() < 1e-12));
        }
        assert!(!factorize(2, &mut [1.0, 2.0, 2.0, 1.0]));
        assert!(!factorize(1, &mut [f64::NAN]));
    }
}
