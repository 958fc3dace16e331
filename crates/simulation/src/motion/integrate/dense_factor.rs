//! In-place factorization of a dense matrix.

/// P A = L U with row exchanges, for n×n matrices of one size; only the constructor allocates.
#[derive(Clone, Debug)]
pub(crate) struct DenseFactor {
    /// Row-major. After [`DenseFactor::factor`] it holds U, and L without its unit diagonal.
    entries: Vec<f64>,
    /// The row that was exchanged with row k.
    exchanged: Vec<usize>,
}

impl DenseFactor {
    pub(crate) fn new(n: usize) -> Self {
        Self { entries: vec![0.0; n * n], exchanged: vec![0; n] }
    }

    /// Writes a column of the matrix.
    pub(crate) fn set_column(&mut self, j: usize, column: impl Iterator<Item = f64>) {
        let n = self.exchanged.len();
        self.entries.iter_mut().skip(j).step_by(n).zip(column).for_each(|(to, x)| *to = x);
    }

    /// Factors the matrix, and returns whether det A > 0: false also if the matrix is singular or not finite.
    pub(crate) fn factor(&mut self) -> bool {
        let n = self.exchanged.len();
        let a = &mut self.entries;
        let mut is_positive = true;
        for k in 0..n {
            let largest =
                (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap_or(k);
            self.exchanged[k] = largest;
            if largest != k {
                let (above, below) = a.split_at_mut(largest * n);
                above[k * n..][..n].swap_with_slice(&mut below[..n]);
                is_positive = !is_positive;
            }
            let (above, below) = a.split_at_mut((k + 1) * n);
            let row = &above[k * n..];
            let pivot = row[k];
            if pivot == 0.0 || !pivot.is_finite() {
                return false;
            }
            is_positive ^= pivot < 0.0;
            for other in below.chunks_exact_mut(n) {
                let ratio = other[k] / pivot;
                other[k] = ratio;
                for (x, above) in other[k + 1..].iter_mut().zip(&row[k + 1..]) {
                    *x -= ratio * above;
                }
            }
        }
        is_positive
    }

    /// x ← A⁻¹ x, after [`DenseFactor::factor`].
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = self.exchanged.len();
        for (k, &other) in self.exchanged.iter().enumerate() {
            x.swap(k, other);
        }
        for i in 0..n {
            let (done, rest) = x.split_at_mut(i);
            rest[0] -= self.entries[i * n..].iter().zip(&*done).map(|(l, x)| l * x).sum::<f64>();
        }
        for i in (0..n).rev() {
            let (own, done) = x[i..].split_at_mut(1);
            let row = &self.entries[i * n + i..];
            own[0] -= row[1..].iter().zip(&*done).map(|(u, x)| u * x).sum::<f64>();
            own[0] /= row[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// A x = b with a zero on the diagonal, compared with the product A x and the sign of nalgebra's
    /// determinant. Entries of magnitude 1 and condition numbers below 1e3 justify 1e-12.
    #[test]
    fn solves_with_exchanges() {
        let mut random = SplitMix64::new(3);
        let mut signs = [0, 0];
        for n in 1..8 {
            for _ in 0..10 {
                let mut a = DMatrix::from_fn(n, n, |_, _| random.uniform(-1.0, 1.0));
                if n > 1 {
                    a[(0, 0)] = 0.0;
                }
                if a.clone().svd(false, false).singular_values.min() < 1e-2 {
                    continue;
                }
                let mut factor = DenseFactor::new(n);
                for j in 0..n {
                    factor.set_column(j, a.column(j).iter().copied());
                }
                let is_positive = factor.factor();
                assert_eq!(is_positive, a.determinant() > 0.0);
                signs[usize::from(is_positive)] += 1;
                let b: Vec<f64> = (0..n).map(|_| random.uniform(-1.0, 1.0)).collect();
                let mut x = b.clone();
                factor.solve(&mut x);
                let defect =
                    (a * DMatrix::from_column_slice(n, 1, &x) - DMatrix::from_column_slice(n, 1, &b)).amax();
                assert!(defect < 1e-12, "{n}: {defect:e}");
            }
        }
        assert!(signs[0] > 5 && signs[1] > 5, "{signs:?}");
    }

    #[test]
    fn a_singular_matrix_has_no_positive_determinant() {
        let mut factor = DenseFactor::new(2);
        factor.set_column(0, [1.0, 2.0].into_iter());
        factor.set_column(1, [2.0, 4.0].into_iter());
        assert!(!factor.factor());
    }
}
