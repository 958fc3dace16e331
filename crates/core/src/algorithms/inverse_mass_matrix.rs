//! The inverse of the mass matrix, from M = LᵀDL.
//!
//! Cost: O(nv² depth). To solve M a = f for a single f, [`forward_dynamics`](crate::forward_dynamics) is
//! cheaper, O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::algorithms::mass_matrix_factor::Elimination;
use crate::model::native::NativeFunction;
use crate::workspace::buffers::{DenseBuffers, Workspace};
use crate::workspace::compiled_once::run;
use crate::workspace::native::computed_natively;

/// M(q)⁻¹, nv×nv symmetric, row-major, both triangles. Column j is the acceleration that a unit force on
/// coordinate j causes at rest, without gravity.
///
/// Computed from the factorization M = LᵀDL, which keeps the tree's zeros, in O(nv² depth). If M is singular,
/// the entries are not finite or meaningless; [`check_rank`](crate::check_rank) detects this.
///
/// ```
/// use nalgebra::DMatrix;
/// use robot_dynamics::algorithms::inverse_mass_matrix;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
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
    workspace.check_inputs(model, q);
    check_length("the inverse mass matrix", inverse.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::InverseMassMatrix, &[q], &mut [&mut *inverse]) {
        return;
    }
    workspace.allocate_matrices(model);
    let Workspace { tree, dense: DenseBuffers { matrix, vector: row, dof_parent, .. }, .. } = workspace;
    run(tree, CompositeBodies { model, q, mass: matrix, entries: Entries::Related });
    run(tree, Elimination { dof_parent, matrix, inverse: Some((row, inverse)) });
}
