//! M̂ = M + γhD + (γh)²K, factored with the tree's zeros.

use dynamics::DynamicsError;

use super::joints::Joints;
use crate::factor::sparse::{self, coordinate_carriers};
use crate::{Model, Workspace, integrate, mass_matrix, mass_rank, neutral};

/// Where M is regular elsewhere but not here, as where hinges come to have one axis, each joint is taken to have this part of the inertia
/// that it moves as armature: without it no pivot is above its rounding, and with it the motion that has no inertia stays finite.
const ARMATURE: f64 = 1e-9;

/// Below this part of M's diagonal a pivot is nearly none.
const NEARLY: f64 = 1e-10;

/// M as it is, and M̂ = LᵀDL.
#[derive(Clone, Debug)]
pub(super) struct StiffFactor {
    carrier: Vec<usize>,
    mass: Vec<f64>,
    entries: Vec<f64>,
    /// Whether M is regular in some pose.
    is_regular: bool,
    /// Of the last factor, in parts of M's diagonal.
    armature: f64,
}

impl StiffFactor {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.nv;
        let zeros = || vec![0.0; n * n];
        let (mass, entries, is_regular) = (zeros(), zeros(), is_regular_somewhere(model));
        Self { carrier: coordinate_carriers(model), mass, entries, is_regular, armature: 0.0 }
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
        self.armature = 0.0;
        let watched = self.watched(joints, g);
        if !self.is_regular || (watched.is_ok() && self.least_pivot() > NEARLY) {
            return watched;
        }
        self.armature = ARMATURE;
        self.watched(joints, g)
    }

    fn watched(&mut self, joints: &Joints, g: f64) -> Result<(), DynamicsError> {
        let n = self.carrier.len();
        stiffened((&self.mass, self.armature), joints, g, &mut self.entries);
        sparse::factor_watched(&self.carrier, &mut self.entries, |k| self.mass[k * n + k])
    }

    /// The sum of M's diagonal.
    pub(super) fn mass_trace(&self) -> f64 {
        self.mass.iter().step_by(self.carrier.len() + 1).sum()
    }

    /// The least pivot, in parts of M's diagonal.
    pub(super) fn least_pivot(&self) -> f64 {
        let n = self.carrier.len();
        (0..n).map(|k| self.entries[k * (n + 1)] / self.mass[k * (n + 1)]).fold(f64::INFINITY, f64::min)
    }

    /// x ← M̂⁻¹x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        sparse::solve(&self.carrier, &self.entries, x);
    }

    /// M̂ as it is, to `matrix`, and λ of its zeros.
    pub(super) fn write(&self, joints: &Joints, g: f64, matrix: &mut [f64]) -> &[usize] {
        stiffened((&self.mass, self.armature), joints, g, matrix);
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

/// `matrix` = M + gD + g²K, with armature in parts of M's diagonal.
fn stiffened((mass, armature): (&[f64], f64), joints: &Joints, g: f64, matrix: &mut [f64]) {
    matrix.copy_from_slice(mass);
    let n = joints.damping.len();
    for k in 0..n {
        let (stiffness, damping) = joints.slopes(k);
        matrix[k * n + k] += g * (damping + g * stiffness);
        if armature > 0.0 {
            matrix[k * n + k] += armature * mass[k * n + k];
        }
    }
}

/// Whether M can be inverted in a pose of no symmetry.
fn is_regular_somewhere(model: &Model) -> bool {
    let way: Vec<f64> = (0..model.nv).map(|k| (1.0 + k as f64).sqrt().fract() + 0.1).collect();
    let mut q = neutral(model);
    integrate(model, &q.clone(), &way, &mut q);
    mass_rank(model, &mut Workspace::new(model), &q) == model.nv
}
