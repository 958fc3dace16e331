//! M = LᵀD L with the tree's zeros left out, O(n depth²) with whole vector registers.
//!
//! Eliminating from the last coordinate to the first fills in nothing: row k of the unit lower triangular L has
//! entries only for the coordinates that carry k. **(RBDA §6.5)** Here they stand by depth, so that the rows of
//! all carriers start with the same columns. Where joints follow others the coordinates form no tree; then every
//! coordinate counts as carried by the one before it, and the rows are those of the dense triangle.

use dynamics::Scalar;

use super::path::LANES;

/// A lower triangle, each row's entries by depth, with room for whole blocks.
#[derive(Clone, Debug)]
pub(crate) struct TreeFactor<S> {
    /// How many coordinates carry each.
    depth: Vec<usize>,
    /// The nearest of them.
    carrier: Vec<usize>,
    /// Blocks of a row.
    width: usize,
    rows: Vec<[S; LANES]>,
    /// The first column beyond each block of a row; as in [`PathBlock`](super::path::PathBlock), loops over blocks ask
    /// for it.
    end: Vec<usize>,
    /// A row, or a vector, by depth.
    scratch: Vec<[S; LANES]>,
}

impl<S: Scalar> TreeFactor<S> {
    pub(super) fn new(depth: Vec<usize>, carrier: Vec<usize>) -> Self {
        let width = depth.iter().max().map_or(0, |deepest| deepest / LANES + 1);
        let zero = [S::zero(); LANES];
        let end = (1..=width).map(|block| block * LANES).collect();
        Self { end, rows: vec![zero; width * depth.len()], scratch: vec![zero; width], width, depth, carrier }
    }

    /// How many coordinates carry coordinate k.
    #[inline(always)]
    pub(super) fn depth(&self, k: usize) -> usize {
        self.depth[k]
    }

    /// The length of the longest row.
    pub(super) fn deepest(&self) -> usize {
        self.depth.iter().max().map_or(0, |deepest| deepest + 1)
    }

    /// Row k, by blocks.
    #[inline(always)]
    pub(super) fn row_mut(&mut self, k: usize) -> &mut [[S; LANES]] {
        &mut self.rows[k * self.width..][..self.width]
    }

    /// All rows, of this many numbers each.
    #[inline(always)]
    pub(super) fn rows(&self) -> (&[S], usize) {
        (self.rows.as_flattened(), self.width * LANES)
    }

    pub(super) fn clear(&mut self) {
        self.rows.fill([S::zero(); LANES]);
    }

    /// M → −L below the diagonal, D⁻¹ on it. What stands beyond the diagonal in its block stays without meaning.
    #[inline(always)]
    pub(super) fn factor(&mut self) {
        let Self { depth, carrier, width, rows, end, scratch } = self;
        for k in (0..depth.len()).rev() {
            let depth = depth[k];
            let (above, below) = rows.split_at_mut(k * *width);
            let row = &mut below[..*width];
            let inverse = S::one() / row.as_flattened()[depth];
            let minus = -inverse;
            for ((scaled, row), &end) in scratch.iter_mut().zip(&*row).zip(&*end) {
                for l in 0..LANES {
                    scaled[l] = row[l] * minus;
                }
                if end > depth {
                    break;
                }
            }
            let mut i = carrier[k];
            for (p, &factor) in scratch.as_flattened()[..depth].iter().enumerate().rev() {
                // Row i of M takes −M_kp L_k.
                let target = above[i * *width..].iter_mut();
                for ((target, row), &end) in target.zip(&*row).zip(&*end) {
                    for l in 0..LANES {
                        target[l] = factor.mul_add(row[l], target[l]);
                    }
                    if end > p {
                        break;
                    }
                }
                i = carrier[i];
            }
            row.copy_from_slice(scratch);
            row.as_flattened_mut()[depth] = inverse;
        }
    }

    /// x ← M⁻¹ x, after [`TreeFactor::factor`].
    #[inline(always)]
    pub(super) fn solve(&mut self, x: &mut [S]) {
        let Self { depth, carrier, width, rows, scratch, .. } = self;
        let x = &mut x[..depth.len()];
        for k in (0..depth.len()).rev() {
            let row = &rows[k * *width..][..*width].as_flattened()[..depth[k]];
            let pushed = x[k];
            let mut i = carrier[k];
            for &factor in row.iter().rev() {
                x[i] = factor.mul_add(pushed, x[i]);
                i = carrier[i];
            }
        }
        let solved = scratch.as_flattened_mut();
        for k in 0..depth.len() {
            let depth = depth[k];
            let row = &rows[k * *width..][..*width].as_flattened()[..=depth];
            let mut sum = x[k] * row[depth];
            for (&factor, &x) in row[..depth].iter().zip(&*solved) {
                sum = factor.mul_add(x, sum);
            }
            x[k] = sum;
            solved[depth] = sum;
        }
    }
}
