//! M⁻¹.

use dynamics::Scalar;

use crate::place::check_length;
use crate::{Model, Workspace, cholesky, mass_matrix, sparse_cholesky};

/// M(q)⁻¹, nv×nv symmetric, row-major, both triangles: column j is the acceleration that a unit force on
/// coordinate j alone causes at rest, without gravity.
///
/// By a Cholesky factorisation of M and nv solves. Where M is singular the entries are not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
pub fn inverse_mass_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    inverse: &mut [S],
) {
    let nv = model.nv;
    check_length("the inverse mass matrix", inverse.len(), nv * nv);
    let mut matrix = core::mem::take(&mut workspace.matrix);
    mass_matrix(model, workspace, q, &mut matrix);
    factor_mass(model, workspace, &mut matrix);
    inverse.fill(S::zero());
    // M⁻¹ is symmetric: solving for its columns fills its rows.
    for (j, row) in inverse.chunks_exact_mut(nv.max(1)).enumerate() {
        row[j] = S::one();
        solve_mass(model, workspace, &matrix, row);
    }
    workspace.matrix = matrix;
}

/// Factors M in place, with the tree's zeros where it is a tree's.
#[inline(always)]
pub(crate) fn factor_mass<S: Scalar>(model: &Model, workspace: &Workspace<S>, mass: &mut [S]) {
    if model.has_mimic {
        cholesky::factor(mass, model.nv);
    } else {
        sparse_cholesky::factor(&workspace.parent_dof, mass);
    }
}

/// x ← M⁻¹ x, from [`factor_mass`].
#[inline(always)]
pub(crate) fn solve_mass<S: Scalar>(model: &Model, workspace: &Workspace<S>, factor: &[S], x: &mut [S]) {
    if model.has_mimic {
        cholesky::solve(factor, model.nv, x);
    } else {
        sparse_cholesky::solve(&workspace.parent_dof, factor, x);
    }
}
