//! Rows with bounds on two sides.

/// The bound of a row that holds as an equality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Lower,
    Upper,
}

impl Side {
    /// The factor that turns the row into cᵀx ≥ bound.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Lower => 1.0,
            Self::Upper => -1.0,
        }
    }
}

/// A row that holds as an equality, and its multiplier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkingRow {
    pub(crate) row: usize,
    pub(crate) side: Side,
    pub(crate) multiplier: f64,
}

/// The rows l ≤ C x ≤ u; C is row-major. Violations count after multiplication by the scale of their row.
#[derive(Clone, Copy)]
pub(crate) struct RowBounds<'a> {
    pub(crate) matrix: &'a [f64],
    pub(crate) lower: &'a [f64],
    pub(crate) upper: &'a [f64],
    pub(crate) scales: &'a [f64],
}

impl<'a> RowBounds<'a> {
    pub(super) fn row(&self, n: usize, row: usize) -> &'a [f64] {
        &self.matrix[row * n..(row + 1) * n]
    }

    /// The bound of a side, with the sign of cᵀx ≥ bound.
    pub(super) fn bound(&self, row: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[row],
            Side::Upper => -self.upper[row],
        }
    }
}

/// The scalar product, with four partial sums.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (heads, tails) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = heads.remainder().iter().zip(tails.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in heads.zip(tails) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
