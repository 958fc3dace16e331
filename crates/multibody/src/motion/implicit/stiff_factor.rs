//! M̂ = M + γhD + (γh)²K, factored with the tree's zeros.

use dynamics::DynamicsError;

use super::joints::Joints;
use crate::factor::sparse::{self, coordinate_carriers};
use crate::{Model, Workspace, mass_matrix};

/// M as it is, and M̂ = LᵀDL.
#[derive(Clone, Debug)]
pub(super) struct StiffFactor {
    carrier: Vec<usize>,
    mass: Vec<f64>,
    entries: Vec<f64>,
}

impl StiffFactor {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.nv;
        Self { carrier: coordinate_carriers(model), mass: vec![0.0; n * n], entries: vec![0.0; n * n] }
    }

    /// At q, with g = γh.
    ///
    /// # Errors
    /// [`DynamicsError::SingularMass`] with the freedom whose pivot is not above the rounding of its row.
    pub(super) fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        joints: &Joints,
        g: f64,
    ) -> Result<(), DynamicsError> {
        mass_matrix(model, workspace, q, &mut self.mass);
        self.stiffen(joints, g)
    }

    /// With another g, M as it is.
    ///
    /// # Errors
    /// As [`factor`](Self::factor).
    pub(super) fn stiffen(&mut self, joints: &Joints, g: f64) -> Result<(), DynamicsError> {
        let n = self.carrier.len();
        stiffened(&self.mass, joints, g, &mut self.entries);
        sparse::factor_watched(&self.carrier, &mut self.entries, |k| self.mass[k * n + k])
    }

    /// x ← M̂⁻¹x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        sparse::solve(&self.carrier, &self.entries, x);
    }

    /// M̂ as it is, to `matrix`, and λ of its zeros.
    pub(super) fn write(&self, joints: &Joints, g: f64, matrix: &mut [f64]) -> &[usize] {
        stiffened(&self.mass, joints, g, matrix);
        &self.carrier
    }

    /// `product` = M x.
    pub(super) fn multiply_mass(&self, x: &[f64], product: &mut [f64]) {
        let n = x.len();
        for (row, product) in self.mass.chunks_exact(n.max(1)).zip(product) {
            *product = row.iter().zip(x).map(|(m, x)| m * x).sum();
        }
    }
}

/// `matrix` = M + gD + g²K.
fn stiffened(mass: &[f64], joints: &Joints, g: f64, matrix: &mut [f64]) {
    matrix.copy_from_slice(mass);
    let n = joints.damping.len();
    for k in 0..n {
        let (stiffness, damping) = joints.slopes(k);
        matrix[k * n + k] += g * (damping + g * stiffness);
    }
}
