//! M = LᵀDL of the implicit rows, refused where it is singular.

use dynamics::DynamicsError;

use crate::factor::sparse::{self, coordinate_carriers};
use crate::{Model, Workspace, mass_matrix};

/// [`sparse`] with memory of its own, and a watch over the pivots.
#[derive(Clone, Debug)]
pub(crate) struct MassFactor {
    parent: Vec<usize>,
    entries: Vec<f64>,
    diagonal: Vec<f64>,
}

impl MassFactor {
    /// Memory for the factor of this model's M.
    pub(crate) fn new(model: &Model) -> Self {
        let nv = model.nv;
        Self { parent: coordinate_carriers(model), entries: vec![0.0; nv * nv], diagonal: vec![0.0; nv] }
    }

    /// Factors M(q).
    ///
    /// # Errors
    /// [`DynamicsError::SingularMass`] with the freedom whose pivot is not above the rounding of its row.
    pub(crate) fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), DynamicsError> {
        let Self { parent, entries: m, diagonal } = self;
        let n = parent.len();
        mass_matrix(model, workspace, q, m);
        for k in 0..n {
            diagonal[k] = m[k * n + k];
        }
        sparse::factor_watched(parent, m, |k| diagonal[k])
    }

    /// x ← M⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        sparse::solve(&self.parent, &self.entries, x);
    }
}
