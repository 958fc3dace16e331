//! The derivative of the shortest multipliers.
//!
//! The shortest λ with Aᵀλ = f lies in the range of A, λ = A z. With the projection Π onto the range, whose
//! dimension stays, any δλ with the right δ(Aᵀλ) gives Π δλ + (1 − Π) δA z.

use nalgebra::{DMatrix, DVector};

use super::super::forward_dynamics::SolvedMotion;
use super::super::row_factor::RowFactor;
use super::super::{ConstraintOptions, RedundantRows};

/// The range of A, and z of λ = A z.
pub(super) struct ShortestMultipliers {
    /// An orthonormal basis of the range of A, K × rank.
    range: DMatrix<f64>,
    /// z, nv.
    pub preimage: DVector<f64>,
}

impl ShortestMultipliers {
    /// `None` if the multipliers are unique, or those of dependent rows are 0.
    pub(super) fn of(solved: &SolvedMotion, options: &ConstraintOptions) -> Option<Self> {
        let SolvedMotion { motion, factor, .. } = solved;
        let is_shortest = matches!(options.redundant, RedundantRows::Proximal { .. });
        (is_shortest && !motion.dependent.is_empty()).then(|| Self::new(factor, &motion.multipliers))
    }

    /// λ = A z with z = M⁻¹Eᵀ y, T y = λ.
    fn new(factor: &RowFactor, multipliers: &DVector<f64>) -> Self {
        let range = factor.triangle.select_columns(&factor.independent).qr().q();
        let preimage = factor.responses.tr_mul(&factor.solve_triangle(multipliers));
        Self { range, preimage }
    }

    /// Π X.
    pub(super) fn project(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        &self.range * self.range.tr_mul(x)
    }
}
