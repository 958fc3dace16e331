//! M = LᵀD L of the implicit rows: without square roots, with the zeros of a tree.

use dynamics::DynamicsError;

use crate::factor::sparse_cholesky::{NONE, coordinate_carriers};
use crate::{Model, Workspace, mass_matrix};

/// L with unit diagonal, and D, in one row-major matrix. **(RBDA §6.5)**
///
/// Row k of L has entries only at the freedoms λ(k), λ(λ(k)), ... that carry freedom k. There are no square
/// roots, so that where M is diagonal a velocity is its momentum divided once: a rounding that does not lean
/// to one side, step after step.
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
        for k in (0..n).rev() {
            let pivot = m[k * n + k];
            // Also refuses NaN.
            if !(pivot > f64::EPSILON * n as f64 * diagonal[k] && pivot.is_finite()) {
                return Err(DynamicsError::SingularMass { coordinate: k, pivot });
            }
            let mut i = parent[k];
            while i != NONE {
                let ratio = m[k * n + i] / pivot;
                let mut j = i;
                while j != NONE {
                    m[i * n + j] -= ratio * m[k * n + j];
                    j = parent[j];
                }
                m[k * n + i] = ratio;
                i = parent[i];
            }
        }
        Ok(())
    }

    /// x ← M⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let Self { parent, entries: l, .. } = self;
        let n = parent.len();
        for k in (0..n).rev() {
            let mut i = parent[k];
            while i != NONE {
                x[i] -= l[k * n + i] * x[k];
                i = parent[i];
            }
        }
        for k in 0..n {
            x[k] /= l[k * n + k];
            let mut i = parent[k];
            while i != NONE {
                x[k] -= l[k * n + i] * x[i];
                i = parent[i];
            }
        }
    }
}
