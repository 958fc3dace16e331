//! The rows of a set of constraints at a state.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::ConstraintError;

/// The rows of a set at a state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstraintRows {
    /// A(q), K×nv.
    pub matrix: DMatrix<f64>,
    /// Ȧv, K: the rate of A v at a = 0.
    pub bias: DVector<f64>,
    /// φ(q) with φ̇ = A v, K; 0 in rows without φ.
    pub position_error: DVector<f64>,
    /// Whether each row has φ.
    pub holonomic: Vec<bool>,
}

impl ConstraintRows {
    /// Returns an error if a row is not finite.
    pub(super) fn check(&self, names: &[String]) -> Result<(), ConstraintError> {
        let finite = |i: usize| {
            self.bias[i].is_finite()
                && self.position_error[i].is_finite()
                && self.matrix.row(i).iter().all(|x| x.is_finite())
        };
        match (0..names.len()).find(|&i| !finite(i)) {
            Some(i) => Err(ConstraintError::NonFiniteRow { name: names[i].clone() }),
            None => Ok(()),
        }
    }
}

/// The position of the next row.
pub(super) struct RowsAt<'a> {
    pub rows: &'a mut ConstraintRows,
    pub at: usize,
}

impl RowsAt<'_> {
    /// Writes one row of A with its entry of Ȧv, and its φ if it has one.
    pub(super) fn push(&mut self, row: &RowDVector<f64>, bias: f64, position_error: Option<f64>) {
        let Self { rows, at } = self;
        rows.matrix.set_row(*at, row);
        rows.bias[*at] = bias;
        rows.position_error[*at] = position_error.unwrap_or(0.0);
        rows.holonomic[*at] = position_error.is_some();
        *at += 1;
    }
}
