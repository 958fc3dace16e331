//! The rows of a set of constraints at a state.

use nalgebra::{DMatrix, DVector};

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
