//! The mobility Λ⁻¹ = J M⁻¹Jᵀ of a frame and its inverse, at most 6×6, without allocation.

use nalgebra::DMatrix;

/// The largest number of directions of a frame.
pub(super) const MOST_ROWS: usize = 6;

/// A mobility below this fraction of the largest one is rounding: each of its two factors is within rounding.
const ROUNDING: f64 = 1e-26;

/// Λ⁻¹; after [`factor`](Self::factor) LᵀD L = Λ⁻¹ with a unit lower triangular L.
pub(super) struct Mobility {
    count: usize,
    entries: [[f64; MOST_ROWS]; MOST_ROWS],
}

impl Mobility {
    /// Creates the matrix from its entries (i, j) with j ≤ i.
    pub(super) fn new(count: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut entries = [[0.0; MOST_ROWS]; MOST_ROWS];
        for i in 0..count {
            for j in 0..=i {
                entries[i][j] = entry(i, j);
            }
        }
        Self { count, entries }
    }

    /// The mobility of each row; 0 beyond the last.
    pub(super) fn diagonal(&self) -> [f64; MOST_ROWS] {
        core::array::from_fn(|k| self.entries[k][k])
    }

    /// Computes L and D, from the last row on.
    ///
    /// # Errors
    /// The row and the pivot that is not above `least` of its row's mobility, or not above its rounding.
    pub(super) fn factor(&mut self, least: f64) -> Result<(), (usize, f64)> {
        let Self { count, entries: a } = self;
        let diagonal: [f64; MOST_ROWS] = core::array::from_fn(|k| a[k][k]);
        let largest = diagonal[..*count].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let least = least.max(f64::EPSILON * *count as f64);
        for k in (0..*count).rev() {
            let pivot = a[k][k];
            // Also true for NaN, and for a row that depends on the others to rounding.
            if !(pivot > (least * diagonal[k].abs()).max(ROUNDING * largest) && pivot.is_finite()) {
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

    /// [`factor`](Self::factor) with damping near a singular pose. Let r be the least pivot relative to the
    /// typical mobility of its row, or 0 for a pivot that is rounding. If r < `damping`, the fraction
    /// `damping` − r of its typical mobility is added to each row's mobility. Returns whether it is damped.
    ///
    /// # Errors
    /// As [`factor`](Self::factor), after damping.
    pub(super) fn factor_damped(
        &mut self,
        damping: f64,
        typical: &[f64; MOST_ROWS],
    ) -> Result<bool, (usize, f64)> {
        let before = self.entries;
        let least = match self.factor(0.0) {
            Ok(()) => (0..self.count).map(|k| self.entries[k][k] / typical[k]).fold(f64::INFINITY, f64::min),
            Err(_) => 0.0,
        };
        if least >= damping {
            return Ok(false);
        }
        self.entries = before;
        for k in 0..self.count {
            self.entries[k][k] += (damping - least) * typical[k];
        }
        self.factor(0.0)?;
        Ok(true)
    }

    /// Λ from the factor: Lᵀy = eⱼ from the last row on, L x = D⁻¹y from the first, then made symmetric.
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
        // The Hilbert matrix plus 1: κ below 3.
        let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) + 1.0 / (i + j + 1) as f64;
        for count in 1..=MOST_ROWS {
            let mut mobility = Mobility::new(count, entry);
            mobility.factor(0.0).unwrap();
            let mut inverse = DMatrix::zeros(count, count);
            mobility.invert(&mut inverse);
            let one = DMatrix::from_fn(count, count, entry) * inverse;
            assert!((one - DMatrix::identity(count, count)).amax() < 1e-15 * 10.0);
        }
    }

    /// The first of two equal rows gives an error; so does a NaN.
    #[test]
    fn a_singular_row_is_named() {
        let same = Mobility::new(3, |i, j| if i == j || i + j == 1 { 2.0 } else { 0.0 }).factor(0.0);
        assert_eq!(same, Err((0, 0.0)));
        let (row, pivot) = Mobility::new(2, |_, _| f64::NAN).factor(0.0).unwrap_err();
        assert!(row == 1 && pivot.is_nan());
    }

    /// One of two nearly equal rows has 1 − c² of its mobility independent of the other. Damping raises that
    /// to the requested fraction, or leaves it.
    #[test]
    fn damping_bounds_the_inverse() {
        for (part, damping) in [(1e-9, 1e-3), (1e-4, 1e-3), (1e-2, 1e-3), (1e-9, 1e-6)] {
            let c = f64::sqrt(1.0 - part);
            let mut mobility = Mobility::new(2, |i, j| if i == j { 2.0 } else { 2.0 * c });
            mobility.factor_damped(damping, &[2.0; MOST_ROWS]).unwrap();
            let mut inverse = DMatrix::zeros(2, 2);
            mobility.invert(&mut inverse);
            let added = f64::max(damping - part, 0.0);
            let entry = |i: usize, j: usize| if i == j { 2.0 * (1.0 + added) } else { 2.0 * c };
            let one = DMatrix::from_fn(2, 2, entry) * &inverse;
            // The rounding is κ ε; `part` itself is 1 − c² with a rounding of ε.
            let rounding = 32.0 * f64::EPSILON / f64::max(part, added);
            assert!((one - DMatrix::identity(2, 2)).amax() < rounding, "{part} {damping}: {inverse}");
            assert!(inverse.amax() < 1.0 / f64::max(part, damping), "{part} {damping}: {inverse}");
        }
        // Two equal rows share their motion, and a row without mobility does not move.
        for corner in [1.0, 0.0] {
            let mut mobility = Mobility::new(2, |i, j| if i + j == 0 { 1.0 } else { corner });
            assert!(mobility.factor_damped(1e-3, &[1.0; MOST_ROWS]).unwrap());
            let mut inverse = DMatrix::zeros(2, 2);
            mobility.invert(&mut inverse);
            let determinant = 1.001 * (corner + 1e-3) - corner * corner;
            assert!((inverse[(0, 0)] * determinant - corner - 1e-3).abs() < 1e-12);
            assert!((inverse[(0, 1)] * determinant + corner).abs() < 1e-12);
        }
        assert!(Mobility::new(2, |_, _| f64::NAN).factor_damped(1e-3, &[1.0; MOST_ROWS]).is_err());
    }
}
