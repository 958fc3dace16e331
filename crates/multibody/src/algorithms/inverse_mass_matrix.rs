//! M⁻¹.

use dynamics::Scalar;

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::algorithms::mass_matrix_factor::Elimination;
use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::scratch::compiled_once::run;
use crate::scratch::native::computed_natively;
use crate::scratch::workspace::{Dense, Workspace};

/// M(q)⁻¹, nv×nv symmetric, row-major, both triangles: column j is the acceleration that a unit force on
/// coordinate j alone causes at rest, without gravity.
///
/// By the factorisation M = LᵀDL with the tree's zeros, O(nv² depth). Where M is singular the entries are not
/// finite or without meaning; [`check_rank`](crate::check_rank) tells.
///
/// ```
/// use multibody::{Workspace, inverse_mass_matrix};
/// use nalgebra::DMatrix;
/// # use multibody::*;
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut dynamics::SplitMix64::new(1));
/// let nv = model.nv();
/// let mut inverse = vec![0.0; nv * nv];
/// inverse_mass_matrix(&model, &mut Workspace::new(&model), &q, &mut inverse);
/// let product = model.mass_matrix(&q)? * DMatrix::from_row_slice(nv, nv, &inverse);
/// assert!((product - DMatrix::identity(nv, nv)).amax() < 1e-9); // κ(M) times rounding
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn inverse_mass_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    inverse: &mut [S],
) {
    workspace.admit(model, q);
    check_length("the inverse mass matrix", inverse.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::InverseMassMatrix, &[q], &mut [&mut *inverse]) {
        return;
    }
    workspace.make_room_for_matrices(model);
    let Workspace { tree, dense: Dense { matrix, vector: row, carrier, .. }, .. } = workspace;
    run(tree, CompositeBodies { model, q, mass: matrix, entries: Entries::Related });
    run(tree, Elimination { carrier, matrix, inverse: Some((row, inverse)) });
}
