//! The mobility Λ⁻¹ = J M⁻¹Jᵀ of a frame and its inverse, at most 6×6, without allocation.

use nalgebra::DMatrix;

use super::MOST_ROWS;

/// Λ⁻¹, and after [`factor`](Self::factor) LᵀD L = Λ⁻¹ with a unit lower triangle L.
pub(super) struct Mobility {
    count: usize,
    entries: [[f64; MOST_ROWS]; MOST_ROWS],
}

impl Mobility {
    /// From entries (i, j) with j ≤ i.
    pub(super) fn new(count: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut entries = [[0.0; MOST_ROWS]; MOST_ROWS];
        for i in 0..count {
            for j in 0..=i {
                entries[i][j] = entry(i, j);
            }
        }
        Self { count, entries }
    }

    /// L and D, from the last row on.
    ///
    /// # Errors
    /// The row and the pivot that is not above the rounding of its row.
    pub(super) fn factor(&mut self) -> Result<(), (usize, f64)> {
        let Self { count, entries: a } = self;
        let diagonal: [f64; MOST_ROWS] = core::array::from_fn(|k| a[k][k]);
        for k in (0..*count).rev() {
            let pivot = a[k][k];
            // Also refuses NaN.
            if !(pivot > f64::EPSILON * diagonal[k].abs() * *count as f64 && pivot.is_finite()) {
                return Err((k, pivot));
            }
            let row = a[k];
            for i in 0..k {
                let ratio = row[i] / pivot;
                for j in 0..=i {
                    a[i][j] -= ratio * row[j];
                }
                a[k][i] = ratio;
            }
        }
        Ok(())
    }

    /// Λ, given the factor: Lᵀy = eⱼ from the last row on, L x = D⁻¹y from the first, then made symmetric.
    pub(super) fn invert(&self, inverse: &mut DMatrix<f64>) {
        let Self { count, entries: l } = self;
        for j in 0..*count {
            let mut x = [0.0; MOST_ROWS];
            x[j] = 1.0;
            for k in (0..*count).rev() {
                let later: f64 = (k + 1..*count).map(|m| l[m][k] * x[m]).sum();
                x[k] -= later;
            }
            for k in 0..*count {
                let earlier: f64 = (0..k).map(|i| l[k][i] * x[i]).sum();
                x[k] = x[k] / l[k][k] - earlier;
            }
            for k in 0..*count {
                inverse[(k, j)] = x[k];
            }
        }
        for i in 0..*count {
            for j in 0..i {
                let mean = 0.5 * (inverse[(i, j)] + inverse[(j, i)]);
                inverse[(i, j)] = mean;
                inverse[(j, i)] = mean;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A A⁻¹ = 1 for a symmetric positive definite A with fractions as entries.
    #[test]
    fn the_inverse_is_one() {
        // Hilbert's matrix plus 1: κ below 3.
        let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) + 1.0 / (i + j + 1) as f64;
        for count in 1..=MOST_ROWS {
            let mut mobility = Mobility::new(count, entry);
            mobility.factor().unwrap();
            let mut inverse = DMatrix::zeros(count, count);
            mobility.invert(&mut inverse);
            let one = DMatrix::from_fn(count, count, entry) * inverse;
            assert!((one - DMatrix::identity(count, count)).amax() < 1e-15 * 10.0);
        }
    }

    /// Two rows that are the same: the first of them is refused, as is a NaN.
    #[test]
    fn a_singular_row_is_named() {
        let same = Mobility::new(3, |i, j| if i == j || i + j == 1 { 2.0 } else { 0.0 }).factor();
        assert_eq!(same, Err((0, 0.0)));
        let (row, pivot) = Mobility::new(2, |_, _| f64::NAN).factor().unwrap_err();
        assert!(row == 1 && pivot.is_nan());
    }
}
