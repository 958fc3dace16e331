//! The factorization of an unsymmetric matrix with the zero pattern of a tree's mass matrix.
//!
//! T = U D L, from the last DoF to the first. Row k of L and column k of U have entries only at the ancestors
//! of DoF k. So there is no fill-in, as in the symmetric [`factor`](super::Paths::factor). The lower triangle
//! is packed by rows and the upper one by columns; the diagonal is in the lower one.

use super::Paths;

impl Paths {
    /// Overwrites both triangles with the factors. It does not pivot: a zero on the diagonal gives numbers
    /// that are not finite.
    pub fn factor_unsymmetric(&self, lower: &mut [f64], upper: &mut [f64]) {
        for row in self.rows.iter().rev() {
            let depth = row.depth();
            let (above, own) = lower.split_at_mut(row.begin);
            let (above_upper, own_upper) = upper.split_at_mut(row.begin);
            let inverse = 1.0 / own[depth];
            let is_nonzero = |k: &usize| own[*k] != 0.0 || own_upper[*k] != 0.0;
            let first = (0..depth).find(is_nonzero).unwrap_or(depth);
            for (i, &column) in self.columns[row.begin..row.diagonal].iter().enumerate().skip(first) {
                let begin = self.rows[column].begin;
                // T_ij ← T_ij − T_ik T_kj/d for all ancestors j of i, and i itself.
                subtract(&mut above[begin + first..=begin + i], own_upper[i] * inverse, &own[first..=i]);
                subtract(&mut above_upper[begin + first..begin + i], own[i] * inverse, &own_upper[first..i]);
            }
            own[..depth].iter_mut().for_each(|entry| *entry *= inverse);
            own_upper[..depth].iter_mut().for_each(|entry| *entry *= inverse);
        }
    }

    /// x ← T⁻¹x from those factors.
    pub fn solve_unsymmetric(&self, lower: &[f64], upper: &[f64], x: &mut [f64]) {
        for (k, row) in self.rows.iter().enumerate().rev() {
            let own = x[k];
            let columns = &self.columns[row.begin..row.diagonal];
            columns.iter().zip(&upper[row.begin..]).for_each(|(&i, entry)| x[i] -= entry * own);
        }
        for (k, row) in self.rows.iter().enumerate() {
            let columns = &self.columns[row.begin..row.diagonal];
            let known: f64 = columns.iter().zip(&lower[row.begin..]).map(|(&i, entry)| entry * x[i]).sum();
            x[k] = x[k] / lower[row.diagonal] - known;
        }
    }
}

/// a ← a − f b.
fn subtract(a: &mut [f64], f: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= f * b);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use robot_dynamics_number::SplitMix64;

    use super::Paths;
    use crate::factorization::sparse::{NONE, dof_ancestors};

    /// Random trees, compared with a dense factorization with pivoting.
    #[test]
    fn unsymmetric_factors_solve_as_dense() {
        let mut paths = Paths::new(3);
        for seed in 0..100 {
            let mut random = SplitMix64::new(seed);
            let n = 1 + (seed % 15) as usize;
            let mut below = |k: usize| usize::try_from(random.next_u64() % (k as u64 + 1)).unwrap();
            let tree: Vec<usize> = (0..n).map(|k| below(k).checked_sub(1).unwrap_or(NONE)).collect();
            paths.choose(&tree);
            let mut dense = DMatrix::zeros(n, n);
            let (mut lower, mut upper) = (vec![0.0; paths.size()], vec![0.0; paths.size()]);
            for k in 0..n {
                dense[(k, k)] = n as f64 + 1.0;
                *paths.diagonal_of(k, &mut lower) = dense[(k, k)];
                for i in dof_ancestors(&tree, k) {
                    dense[(k, i)] = random.uniform(-1.0, 1.0);
                    dense[(i, k)] = random.uniform(-1.0, 1.0);
                    *paths.entry_of(k, i, &mut lower) = dense[(k, i)];
                    *paths.entry_of(k, i, &mut upper) = dense[(i, k)];
                }
            }
            let right = DVector::from_fn(n, |_, _| random.uniform(-1.0, 1.0));
            let mut x = right.as_slice().to_vec();
            paths.factor_unsymmetric(&mut lower, &mut upper);
            paths.solve_unsymmetric(&lower, &upper, &mut x);
            let expected = dense.lu().solve(&right).unwrap();
            // The matrices are diagonally dominant: the error is a few rounding errors.
            assert!((DVector::from_vec(x) - expected).amax() < 1e-14, "seed {seed}");
        }
    }
}
