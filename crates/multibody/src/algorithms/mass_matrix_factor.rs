//! M = LᵀDL.

use dynamics::Scalar;
use number::View;
use number::dispatch::{Hardware, Kernel};

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::factor::sparse;
use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::scratch::compiled_once::{OverNumber, compiled_once, run};
use crate::scratch::native::computed_natively;
use crate::scratch::tree::TreeMemory;
use crate::scratch::workspace::{Dense, Workspace};

/// The factor of M(q) = LᵀDL, nv×nv row-major: below the diagonal L, whose own diagonal is 1, on the diagonal D, above it zeros.
///
/// Row k of L has entries only at the freedoms that carry k: the tree's zeros stay zeros. **(RBDA §6.5)** M a = f is
/// solved by Lᵀz = f from the last freedom to the first, D y = z, L a = y from the first to the last; det M is the product of
/// the diagonal. Where M is singular the entries are not finite or without meaning; [`check_rank`](crate::check_rank) tells.
///
/// ```
/// use multibody::{Workspace, mass_matrix_factor};
/// use nalgebra::DMatrix;
/// # use multibody::*;
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, .. } = random_state(&model, &mut dynamics::SplitMix64::new(1));
/// let nv = model.nv();
/// let mut factor = vec![0.0; nv * nv];
/// mass_matrix_factor(&model, &mut Workspace::new(&model), &q, &mut factor);
/// let mut l = DMatrix::from_row_slice(nv, nv, &factor);
/// let d = DMatrix::from_diagonal(&l.diagonal());
/// l.fill_diagonal(1.0);
/// let mass = model.mass_matrix(&q)?;
/// assert!((l.transpose() * d * &l - &mass).amax() < 1e-14 * mass.amax());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn mass_matrix_factor<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], factor: &mut [S]) {
    workspace.admit(model, q);
    check_length("the factor of the mass matrix", factor.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::MassMatrixFactor, &[q], &mut [&mut *factor]) {
        return;
    }
    workspace.make_room_for_matrices(model);
    let Workspace { tree, dense: Dense { matrix, carrier, .. }, .. } = workspace;
    run(tree, CompositeBodies { model, q, mass: matrix, entries: Entries::Related });
    run(tree, Elimination { carrier, matrix, inverse: None });
    factor.fill(S::zero());
    for k in 0..model.nv {
        for i in core::iter::once(k).chain(sparse::carriers(carrier, k)) {
            factor[k * model.nv + i] = matrix[k * model.nv + i];
        }
    }
}

/// M, all of it, becomes its factor; and then, where there is scratch and room for it, the inverse from that.
pub(crate) struct Elimination<'a, S> {
    pub carrier: &'a [usize],
    pub matrix: &'a mut [S],
    pub inverse: Option<(&'a mut [S], &'a mut [S])>,
}

compiled_once!(EliminationKind, Elimination);

impl<S: Scalar> Kernel<OverNumber, S> for Elimination<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, _: &mut TreeMemory<N>) {
        let Self { carrier, matrix, inverse } = self;
        sparse::factor(carrier, matrix);
        if let Some((row, inverse)) = inverse {
            sparse::invert(carrier, matrix, row, inverse);
            sparse::mirror(carrier.len(), inverse);
        }
    }
}
