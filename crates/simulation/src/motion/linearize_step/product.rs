//! Products of Jacobians with the changes of a stage.

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

/// The rows and columns of a product that are summed in registers.
const ROWS: usize = 4;
const COLUMNS: usize = 8;

/// `sum` = Σ A X over pairs of a matrix A and a change X of `width` columns, row-major.
pub(in crate::motion) fn multiply_changes(pairs: &[(&[f64], &[f64])], width: usize, sum: &mut [f64]) {
    if !sum.is_empty() {
        run_here(Products { pairs, width, sum });
    }
}

struct Products<'a> {
    pairs: &'a [(&'a [f64], &'a [f64])],
    width: usize,
    sum: &'a mut [f64],
}

impl Call for Products<'_> {
    #[inline(always)]
    fn call<H: Hardware>(mut self) {
        let eights = self.width - self.width % COLUMNS;
        let fours = self.width - self.width % (COLUMNS / 2);
        (0..eights).step_by(COLUMNS).for_each(|column| self.columns::<COLUMNS>(column));
        (eights..fours).step_by(COLUMNS / 2).for_each(|column| self.columns::<{ COLUMNS / 2 }>(column));
        (fours..self.width).for_each(|column| self.columns::<1>(column));
    }
}

impl Products<'_> {
    /// Computes some columns of the sum.
    #[inline(always)]
    fn columns<const C: usize>(&mut self, column: usize) {
        let rows = self.sum.len() / self.width;
        let fours = rows - rows % ROWS;
        (0..fours).step_by(ROWS).for_each(|row| self.tile::<ROWS, C>(row, column));
        (fours..rows).for_each(|row| self.tile::<1, C>(row, column));
    }

    /// Computes R rows and C columns.
    #[inline(always)]
    fn tile<const R: usize, const C: usize>(&mut self, row: usize, column: usize) {
        let (rows, width) = (self.sum.len() / self.width, self.width);
        let mut sum = [[0.0; C]; R];
        for (matrix, change) in self.pairs {
            let n = matrix.len() / rows;
            let factors: [&[f64]; R] = core::array::from_fn(|i| &matrix[(row + i) * n..][..n]);
            for (k, change) in change.chunks_exact(width).enumerate() {
                let change: &[f64; C] = change[column..].first_chunk().expect("a column within the change");
                for (sum, factors) in sum.iter_mut().zip(factors) {
                    sum.iter_mut().zip(change).for_each(|(sum, x)| *sum += factors[k] * x);
                }
            }
        }
        for (i, sum) in sum.iter().enumerate() {
            self.sum[(row + i) * width + column..][..C].copy_from_slice(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// The reference sums at most 2 · 23 products of numbers below 1 in another order: at most 46² roundings.
    #[test]
    fn products_are_those_of_matrices() {
        let mut random = SplitMix64::new(5);
        for n in [1, 2, 3, 4, 7, 8, 13, 23] {
            let mut matrix = |rows: usize, columns: usize| {
                DMatrix::from_fn(rows, columns, |_, _| random.uniform(-1.0, 1.0))
            };
            let (a, b, x, y) = (matrix(n, n), matrix(n, n), matrix(n, 3 * n), matrix(n, 3 * n));
            let rows = [&a, &b, &x, &y].map(|matrix| matrix.transpose().as_slice().to_vec());
            let mut sum = vec![f64::NAN; 3 * n * n];
            multiply_changes(&[(&rows[0], &rows[2]), (&rows[1], &rows[3])], 3 * n, &mut sum);
            let off = (DMatrix::from_row_slice(n, 3 * n, &sum) - (a * x + b * y)).amax();
            assert!(off <= 46.0 * 46.0 * f64::EPSILON, "{n}: {off:e}");
        }
    }
}
