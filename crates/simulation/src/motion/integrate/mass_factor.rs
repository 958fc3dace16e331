//! The factorization M = LᵀDL of the implicit rows, with a check of the rank.

use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::coordinate_parents;
use robot_dynamics_core::{Model, Workspace, mass_matrix};
use robot_dynamics_integrators::IntegratorError;

/// [`sparse`] factorization with its own memory and a check of the pivots.
#[derive(Clone, Debug)]
pub struct MassFactor {
    parent: Vec<usize>,
    entries: Vec<f64>,
    diagonal: Vec<f64>,
}

impl MassFactor {
    /// Allocates memory for the factor of this model's M.
    pub fn new(model: &Model) -> Self {
        let nv = model.nv;
        Self { parent: coordinate_parents(model), entries: vec![0.0; nv * nv], diagonal: vec![0.0; nv] }
    }

    /// Factors M(q).
    ///
    /// # Errors
    /// [`IntegratorError::SingularMass`] with the degree of freedom whose pivot is not above the rounding of
    /// its row.
    pub fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), IntegratorError> {
        self.factor_sum(model, workspace, q, |_| 0.0)
    }

    /// Factors M(q) + diag(d) with entries d ≥ 0.
    ///
    /// # Errors
    /// As [`factor`](Self::factor).
    pub fn factor_sum(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        added: impl Fn(usize) -> f64,
    ) -> Result<(), IntegratorError> {
        let Self { parent, entries: m, diagonal } = self;
        let n = parent.len();
        mass_matrix(model, workspace, q, m);
        for k in 0..n {
            diagonal[k] = m[k * n + k];
            m[k * n + k] += added(k);
        }
        sparse::factor_watched(parent, m, |k| diagonal[k])
    }

    /// x ← M⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        sparse::solve(&self.parent, &self.entries, x);
    }
}
