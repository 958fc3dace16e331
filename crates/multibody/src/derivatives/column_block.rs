//! The freedoms' columns, four side by side.

use dynamics::Scalar;

use crate::Model;
use crate::algebra::V3;
use crate::workspace::Force;

/// First row of S ×\* F + I ψ′ + 2B ψ.
pub(super) const BENT: usize = 0;
/// First row of I (Ṡ + ψ) + 2B S.
pub(super) const ABOVE: usize = 6;
/// First row of I S.
pub(super) const INERTIAL: usize = 12;
/// First row of the moment of 2Bᵀ S, which has no force.
pub(super) const TURNING: usize = 18;
const ROWS: usize = 21;

/// Columns side by side.
pub(super) const LANES: usize = 4;

/// The columns of four freedoms side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColumnBlock<S>([[S; LANES]; ROWS]);

impl<S: Scalar> ColumnBlock<S> {
    pub(crate) fn zero() -> Self {
        Self([[S::zero(); LANES]; ROWS])
    }

    /// Writes three rows of a freedom's column.
    #[inline(always)]
    pub(super) fn write<const FIRST: usize>(&mut self, dof: usize, vector: V3<S>) {
        let [x, y, z] = vector.array();
        let lane = dof % LANES;
        self.0[FIRST][lane] = x;
        self.0[FIRST + 1][lane] = y;
        self.0[FIRST + 2][lane] = z;
    }

    /// Writes six rows of a freedom's column.
    #[inline(always)]
    pub(super) fn write_force<const FIRST: usize>(&mut self, dof: usize, force: &Force<S>) {
        let ([a, b, c], [d, e, f]) = (force.linear.array(), force.angular.array());
        let lane = dof % LANES;
        self.0[FIRST][lane] = a;
        self.0[FIRST + 1][lane] = b;
        self.0[FIRST + 2][lane] = c;
        self.0[FIRST + 3][lane] = d;
        self.0[FIRST + 4][lane] = e;
        self.0[FIRST + 5][lane] = f;
    }

    /// Σₖ weightₖ row_{first+k}.
    #[inline(always)]
    pub(super) fn project<const FIRST: usize, const K: usize>(&self, weights: &[S; K]) -> [S; LANES] {
        let mut sum = [S::zero(); LANES];
        for k in 0..K {
            let row = &self.0[FIRST + k];
            for l in 0..LANES {
                sum[l] = weights[k].mul_add(row[l], sum[l]);
            }
        }
        sum
    }
}

/// How many blocks the freedoms fill.
pub(crate) fn column_blocks(model: &Model) -> usize {
    model.dofs.len().div_ceil(LANES)
}
