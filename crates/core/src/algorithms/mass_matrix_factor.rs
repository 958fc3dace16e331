//! The factorization M = LᵀDL, which keeps the tree's zeros.
//!
//! Cost: O(n depth²); O(n³) with mimic joints, or with armature on tendons over several joints. **(RBDA
//! §6.5)**

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::factorization::sparse;
use crate::model::native::NativeFunction;
use crate::workspace::buffers::{DenseBuffers, Workspace};
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};

/// The factor of M(q) = LᵀDL, nv×nv row-major: L below the diagonal, D on the diagonal, zeros above. The
/// diagonal of L is 1.
///
/// Row k of L has entries only at the ancestors of DoF k: the factorization keeps the tree's zeros. **(RBDA
/// §6.5)**
///
/// To solve M a = f, solve Lᵀz = f from the last DoF to the first. Then y = D⁻¹z, and L a = y from the first
/// to the last. The determinant of M is the product of the diagonal. If M is singular, the entries are not
/// finite or meaningless; [`check_rank`](crate::check_rank) detects this.
///
/// ```
/// use nalgebra::DMatrix;
/// use robot_dynamics::algorithms::mass_matrix_factor;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, .. } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
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
    workspace.check_inputs(model, q);
    check_length("the factor of the mass matrix", factor.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::MassMatrixFactor, &[q], &mut [&mut *factor]) {
        return;
    }
    workspace.allocate_matrices(model);
    let Workspace { tree, dense: DenseBuffers { matrix, dof_parent, .. }, .. } = workspace;
    run(tree, CompositeBodies { model, q, mass: matrix, entries: Entries::Related });
    run(tree, Elimination { dof_parent, matrix, inverse: None });
    factor.fill(S::zero());
    for k in 0..model.nv {
        for i in core::iter::once(k).chain(sparse::dof_ancestors(dof_parent, k)) {
            factor[k * model.nv + i] = matrix[k * model.nv + i];
        }
    }
}

/// Overwrites M with its factor and, if there is a buffer for it, computes the inverse from the factor.
pub struct Elimination<'a, S> {
    pub dof_parent: &'a [usize],
    pub matrix: &'a mut [S],
    pub inverse: Option<(&'a mut [S], &'a mut [S])>,
}

compiled_once!(Elimination);

impl<S: Scalar> Kernel<TreeStorage, S> for Elimination<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, _: &mut TreeMemory<N>) {
        let Self { dof_parent, matrix, inverse } = self;
        sparse::factor(dof_parent, matrix);
        if let Some((row, inverse)) = inverse {
            sparse::invert(dof_parent, matrix, row, inverse);
            sparse::mirror(dof_parent.len(), inverse);
        }
    }
}
