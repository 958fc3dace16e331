//! A row-major matrix whose memory is reused, and the orthogonal elimination of equations.

use crate::optimal::dense::add_product;
use crate::quadratic_program::dot;

/// A row-major matrix. Changes of its size within its capacity do not allocate.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) data: Vec<f64>,
}

/// Rows with at most this number of entries are multiplied entry by entry.
const SPARSE: usize = 4;

impl Matrix {
    pub(super) fn with_capacity(rows: usize, columns: usize) -> Self {
        Self { rows: 0, columns: 0, data: Vec::with_capacity(rows * columns) }
    }

    /// Zeros of this size.
    pub(super) fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        self.data.clear();
        self.data.resize(rows * columns, 0.0);
    }

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.data[row * self.columns..(row + 1) * self.columns]
    }

    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.data[row * self.columns..(row + 1) * self.columns]
    }

    /// Copies a matrix; unlike the derived `clone_from` it does not allocate.
    fn copy_from(&mut self, other: &Self) {
        (self.rows, self.columns) = (other.rows, other.columns);
        self.data.clear();
        self.data.extend_from_slice(&other.data);
    }

    /// Removes the first columns.
    pub(super) fn drop_columns(&mut self, count: usize) {
        let (old, new) = (self.columns, self.columns - count);
        for row in 0..self.rows {
            self.data.copy_within(row * old + count..(row + 1) * old, row * new);
        }
        self.columns = new;
        self.data.truncate(self.rows * new);
    }

    /// Appends a row of zeros.
    pub(super) fn push_row(&mut self) -> &mut [f64] {
        self.rows += 1;
        self.data.resize(self.rows * self.columns, 0.0);
        self.row_mut(self.rows - 1)
    }

    /// self ← A B.
    pub(super) fn set_product(&mut self, a: &Matrix, b: &Matrix) {
        self.reset(a.rows, b.columns);
        let width = b.columns;
        if width == 0 {
            return;
        }
        let is_sparse = |row: &[f64]| row.iter().filter(|x| **x != 0.0).count() <= SPARSE;
        let mut row = 0;
        while row < a.rows {
            let first = row;
            while row < a.rows && !is_sparse(a.row(row)) {
                row += 1;
            }
            if row > first {
                let (from, to) = (first * a.columns..row * a.columns, first * width..row * width);
                add_product(a.columns, width, &a.data[from], &b.data, &mut self.data[to]);
            } else {
                let to = &mut self.data[row * width..(row + 1) * width];
                for (j, &factor) in a.row(row).iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    to.iter_mut().zip(b.row(j)).for_each(|(to, b)| *to += factor * b);
                }
                row += 1;
            }
        }
    }
}

/// A row whose part outside the span of the others is below this fraction of it depends on them.
const DEPENDENCE: f64 = 1e-9;

/// The elimination of E x = e: x = x₀ + N z, with N orthonormal and x₀ orthogonal to it.
///
/// Reflections from the right make E, with its rows in the order of their independent parts, lower
/// triangular: E H₁ … Hᵣ = (L, 0).
#[derive(Clone, Debug, Default)]
pub(super) struct Elimination {
    /// The rows, reflected; row k keeps wₖ after its diagonal.
    reflected: Matrix,
    /// The norms of the original rows, in the same order.
    norms: Vec<f64>,
    /// The original index of each row.
    order: Vec<usize>,
    /// The diagonal of L, and 2 / |wₖ|².
    diagonal: Vec<f64>,
    factors: Vec<f64>,
    scratch: Vec<f64>,
}

/// The rows that depend on others, and contradict them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contradiction {
    /// The index of the row.
    pub(super) row: usize,
    /// The part of its right side that the other rows do not allow, for a row of length one.
    pub(super) residual: f64,
}

/// A contradiction below this fraction of the right sides is rounding.
const CONSISTENCY: f64 = 1e-6;

impl Elimination {
    pub(super) fn with_capacity(rows: usize, columns: usize) -> Self {
        Self {
            reflected: Matrix::with_capacity(rows, columns),
            norms: Vec::with_capacity(rows),
            order: Vec::with_capacity(rows),
            diagonal: Vec::with_capacity(rows),
            factors: Vec::with_capacity(rows),
            scratch: Vec::with_capacity(columns.max(rows)),
        }
    }

    /// The number of independent rows.
    pub(super) fn rank(&self) -> usize {
        self.diagonal.len()
    }

    /// Factors E.
    pub(super) fn factor(&mut self, matrix: &Matrix) {
        let (m, n) = (matrix.rows, matrix.columns);
        self.reflected.copy_from(matrix);
        self.order.clear();
        self.order.extend(0..m);
        self.diagonal.clear();
        self.factors.clear();
        self.norms.clear();
        for row in self.reflected.data.chunks_exact_mut(n.max(1)) {
            let norm = dot(row, row).sqrt();
            self.norms.push(norm);
            if norm > 0.0 {
                for x in row {
                    *x /= norm;
                }
            }
        }
        for k in 0..m.min(n) {
            let free = |row: usize| dot(&self.reflected.row(row)[k..], &self.reflected.row(row)[k..]);
            let best = (k..m).map(|row| (row, free(row))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((pivot, size)) = best.filter(|(_, size)| *size > DEPENDENCE * DEPENDENCE) else { break };
            self.swap(k, pivot);
            self.reflect(k, size.sqrt());
        }
    }

    fn swap(&mut self, a: usize, b: usize) {
        let n = self.reflected.columns;
        if a != b {
            let (above, below) = self.reflected.data.split_at_mut(b * n);
            above[a * n..(a + 1) * n].swap_with_slice(&mut below[..n]);
            self.order.swap(a, b);
            self.norms.swap(a, b);
        }
    }

    /// Reflects row k to (…, d, 0, …), and applies the reflection to the rows below.
    fn reflect(&mut self, k: usize, norm: f64) {
        let n = self.reflected.columns;
        let (above, below) = self.reflected.data.split_at_mut((k + 1) * n);
        let w = &mut above[k * n + k..];
        let d = if w[0] > 0.0 { -norm } else { norm };
        w[0] -= d;
        let factor = 2.0 / dot(w, w);
        for row in below.chunks_exact_mut(n) {
            let row = &mut row[k..];
            let along = factor * dot(w, row);
            row.iter_mut().zip(&*w).for_each(|(x, w)| *x -= along * w);
        }
        self.diagonal.push(d);
        self.factors.push(factor);
    }

    /// x₀ for the right sides e.
    pub(super) fn particular(&mut self, right: &[f64], x: &mut Vec<f64>) -> Result<(), Contradiction> {
        let (n, rank) = (self.reflected.columns, self.rank());
        x.clear();
        x.resize(n, 0.0);
        let normalized = |k: usize| {
            let norm = self.norms[k];
            right[self.order[k]] / if norm > 0.0 { norm } else { 1.0 }
        };
        let largest = (0..self.order.len()).map(|k| normalized(k).abs()).fold(0.0, f64::max);
        for k in 0..self.order.len() {
            let row = self.reflected.row(k);
            let rest = normalized(k) - dot(&row[..k.min(rank)], &x[..k.min(rank)]);
            if k < rank {
                x[k] = rest / self.diagonal[k];
            } else if rest.abs() > CONSISTENCY * (1.0 + largest) {
                return Err(Contradiction { row: self.order[k], residual: rest });
            }
        }
        for k in (0..rank).rev() {
            let w = &self.reflected.row(k)[k..];
            let along = self.factors[k] * dot(w, &x[k..]);
            x[k..].iter_mut().zip(w).for_each(|(x, w)| *x -= along * w);
        }
        Ok(())
    }

    /// N, n × (n − rank).
    pub(super) fn null_basis(&mut self, basis: &mut Matrix) {
        self.columns_from(self.rank(), basis);
    }

    /// An orthonormal basis, n × n; its first columns span the rows of E, and its last ones are N.
    pub(super) fn whole_basis(&mut self, basis: &mut Matrix) {
        self.columns_from(0, basis);
    }

    /// The columns `first`… of H₁ … Hᵣ.
    fn columns_from(&mut self, first: usize, basis: &mut Matrix) {
        let (n, rank) = (self.reflected.columns, self.rank());
        let width = n - first;
        basis.reset(n, width);
        if width == 0 {
            return;
        }
        for j in 0..width {
            basis.row_mut(first + j)[j] = 1.0;
        }
        for k in (0..rank).rev() {
            let w = &self.reflected.row(k)[k..];
            self.scratch.clear();
            self.scratch.resize(width, 0.0);
            let rows = &mut basis.data[k * width..];
            for (w, row) in w.iter().zip(rows.chunks_exact(width)) {
                self.scratch.iter_mut().zip(row).for_each(|(sum, x)| *sum += w * x);
            }
            for (w, row) in w.iter().zip(rows.chunks_exact_mut(width)) {
                let along = self.factors[k] * w;
                row.iter_mut().zip(&self.scratch).for_each(|(x, sum)| *x -= along * sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    #[test]
    fn eliminations_solve_their_equations() {
        let mut random = SplitMix64::new(3);
        for (m, n, dependent) in [(3, 7, 0), (6, 6, 0), (5, 9, 2), (1, 1, 0), (0, 4, 0)] {
            let (mut e, mut right) = (Matrix::default(), Vec::new());
            e.reset(0, n);
            for _ in 0..m {
                e.push_row().iter_mut().for_each(|x| *x = random.uniform(-5.0, 5.0));
                right.push(random.uniform(-5.0, 5.0));
            }
            for row in 0..dependent {
                let sum: Vec<f64> = e.row(row).iter().zip(e.row(row + 1)).map(|(a, b)| a - 2.0 * b).collect();
                e.push_row().copy_from_slice(&sum);
                right.push(right[row] - 2.0 * right[row + 1]);
            }
            let mut elimination = Elimination::default();
            elimination.factor(&e);
            assert_eq!(elimination.rank(), m);
            let (mut x, mut basis, mut image) = (Vec::new(), Matrix::default(), Matrix::default());
            elimination.particular(&right, &mut x).expect("consistent rows");
            elimination.null_basis(&mut basis);
            image.set_product(&e, &basis);
            // Products of nine numbers up to 5.
            assert!(image.data.iter().all(|x| x.abs() < 1e-13));
            for row in 0..e.rows {
                // The condition number of the random rows is below 1e3.
                assert!((dot(e.row(row), &x) - right[row]).abs() < 1e-11);
            }
            let mut whole = Matrix::default();
            elimination.whole_basis(&mut whole);
            for j in 0..n {
                assert_eq!(whole.row(j)[m..], *basis.row(j));
                let length: f64 = (0..n).map(|i| whole.row(i)[j] * whole.row(i)[j]).sum();
                assert!((length - 1.0).abs() < 1e-14);
            }
            for j in 0..basis.columns {
                let along: f64 = (0..n).map(|i| basis.row(i)[j] * x[i]).sum();
                assert!(along.abs() < 1e-12);
            }
            if dependent > 0 {
                right[m] += 1.0;
                let contradiction = elimination.particular(&right, &mut x).expect_err("a contradiction");
                assert!(contradiction.residual.abs() > 1e-3);
            }
        }
    }
}
