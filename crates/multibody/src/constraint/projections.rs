//! The projections that take the constraint force out of the equation of motion.

use nalgebra::DMatrix;

use super::error::check_entries;
use super::row_factor::{MassFactor, RowFactor};
use super::{ConstrainedMotionError, ConstraintOptions, ConstraintSet};
use crate::model::length::check_length;
use crate::{Model, Workspace};

/// P_u on forces and P on velocities, both nv×nv of rank nv − rank A.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeProjections {
    /// P_u = 1 − Aᵀ(AM⁻¹Aᵀ)⁻¹AM⁻¹: P_u Aᵀ = 0. **(PRM 10.18)**
    pub force: DMatrix<f64>,
    /// P = M⁻¹P_uM = P_uᵀ: A P = 0. **(PRM 10.19)**
    pub velocity: DMatrix<f64>,
    /// The rank of A.
    pub rank: usize,
}

/// P and P_u at q. Every velocity splits into P v, which A allows, and (1−P) v; both are orthogonal in M.
///
/// # Errors
/// [`ConstrainedMotionError`] if M is singular, or q, an option, a row or a result is not finite.
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn constraint_projections(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
) -> Result<TreeProjections, ConstrainedMotionError> {
    workspace.admit(model, q);
    let nv = model.nv();
    check_length("q", q.len(), model.nq());
    check_entries("q", q)?;
    options.check()?;
    let rows = set.rows(model, workspace, q, &vec![0.0; nv]);
    let mass = MassFactor::new(model, workspace, q)?;
    let factor = RowFactor::of(set, &mass, &rows, options.dependence)?;
    // With A = T E the middle factor cancels: P_u = 1 − Eᵀ E M⁻¹.
    let force = DMatrix::identity(nv, nv) - factor.forces.tr_mul(&factor.responses);
    check_entries("the projection", force.as_slice())?;
    Ok(TreeProjections { velocity: force.transpose(), force, rank: factor.rank() })
}
