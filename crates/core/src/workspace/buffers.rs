//! The scratch memory of the algorithms, which the caller owns.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::dispatch::StateMemory;

use crate::factorization::sparse::coordinate_parents;
use crate::model::identity::Identity;
use crate::workspace::extent;
use crate::workspace::tree::TreeMemory;
use crate::{InstructionSet, Model};

/// The number of degrees of freedom above which matrices are allocated when a call first needs them. A matrix
/// of this size takes 8 MiB. Those of the largest robots exceed a machine's memory, and their recursions need
/// none.
const MATRICES_FROM_START: usize = 1024;

/// Scratch for the algorithms on one model, over one scalar type. Use one per thread.
///
/// Every algorithm writes the entries that it reads. No call depends on the results of an earlier one, so one
/// workspace serves all algorithms in any order.
///
/// For a robot of more than 1024 degrees of freedom, the first call that needs a matrix of the workspace
/// allocates it. Such calls are the inverse and the factor of M, forward dynamics by that factor, and the
/// derivatives of forward dynamics.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar = f64> {
    /// The robot that it belongs to.
    pub robot: Identity,
    pub tree: TreeMemory<S>,
    pub dense: DenseBuffers<S>,
    /// Scratch for the rank check.
    pub rank: extent::RankBuffers,
    /// The newest instructions of the tree's memory, if the matrices are not allocated yet.
    without_matrices: Option<InstructionSet>,
}

/// Memory for computations with the recursions' results.
#[derive(Clone, Debug)]
pub struct DenseBuffers<S> {
    /// nv×nv, row-major: M, then its factor. See [`Workspace::allocate_matrices`].
    pub matrix: Vec<S>,
    /// nv numbers.
    pub vector: Vec<S>,
    /// Twice nq numbers: a configuration and its rate.
    pub coordinates: Vec<S>,
    /// λ: the parent of each coordinate, or `sparse::NONE`.
    pub dof_parent: Vec<usize>,
}

impl<S: Scalar> DenseBuffers<S> {
    fn new(model: &Model, has_matrix: bool) -> Self {
        let zeros = |count: usize| vec![S::zero(); count];
        let (nq, nv) = (model.nq, model.nv);
        Self {
            matrix: zeros(if has_matrix { nv * nv } else { 0 }),
            vector: zeros(nv),
            coordinates: zeros(2 * nq),
            dof_parent: coordinate_parents(model),
        }
    }
}

impl<S: Scalar> Workspace<S> {
    /// Allocates the memory for this model. Calls that take a workspace do not allocate.
    pub fn new(model: &Model) -> Self {
        Self::limited(model, InstructionSet::best())
    }

    /// As [`Workspace::new`], but limits the algorithms to these instructions, to reproduce the results of an
    /// older machine. Results agree up to rounding; AVX2 and AVX-512 give the same bits.
    pub fn limited(model: &Model, limit: InstructionSet) -> Self {
        let has_matrices = model.nv <= MATRICES_FROM_START;
        let dense = DenseBuffers::new(model, has_matrices);
        let dof_parent = if has_matrices { &dense.dof_parent[..] } else { &[] };
        let tree = TreeMemory::limited(model, dof_parent, limit);
        Self { without_matrices: (!has_matrices).then_some(limit), ..Self::over(model, tree, dense) }
    }

    fn over(model: &Model, tree: TreeMemory<S>, dense: DenseBuffers<S>) -> Self {
        let rank = extent::RankBuffers::new(model);
        Self { robot: model.identity.clone(), tree, dense, rank, without_matrices: None }
    }

    /// Allocates the workspace's matrices if they are not allocated yet.
    #[inline(always)]
    pub fn allocate_matrices(&mut self, model: &Model) {
        if let Some(limit) = self.without_matrices {
            self.allocate_matrices_with(model, limit);
        }
    }

    #[cold]
    #[inline(never)]
    fn allocate_matrices_with(&mut self, model: &Model, limit: InstructionSet) {
        let tree = TreeMemory::limited(model, &self.dense.dof_parent, limit);
        let native = core::mem::replace(&mut self.tree, tree).native;
        self.tree.native = native;
        self.dense.matrix = vec![S::zero(); model.nv * model.nv];
        self.without_matrices = None;
    }

    /// Panics if the workspace belongs to another model or `q` has the wrong length.
    #[inline(always)]
    #[track_caller]
    pub fn check_inputs(&self, model: &Model, q: &[S]) {
        model.check_identity(&self.robot, "the workspace");
        check_length("q", q.len(), model.nq);
    }

    /// Memory over one scalar type only, for kernels.
    pub fn scratch(model: &Model) -> Self {
        let dense = DenseBuffers::new(model, true);
        Self::over(model, TreeMemory::portable(model, &dense.dof_parent), dense)
    }

    /// The instructions of its recursions. If these are AVX2, derivatives may use AVX-512.
    pub fn instruction_set(&self) -> InstructionSet {
        match self.tree.fast.as_ref().map(StateMemory::instruction_set) {
            None => InstructionSet::Portable,
            Some(InstructionSet::Avx512) => InstructionSet::Avx2,
            Some(set) => set,
        }
    }
}
