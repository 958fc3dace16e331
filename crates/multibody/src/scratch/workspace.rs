//! The scratch memory of the algorithms; it belongs to the caller.

use dynamics::Scalar;
use number::dispatch::OneState;

use crate::factor::sparse::coordinate_carriers;
use crate::model::identity::Identity;
use crate::model::length::check_length;
use crate::scratch::extent;
use crate::scratch::tree::TreeMemory;
use crate::{InstructionSet, Model};

/// Robots of more degrees of freedom get their memory for matrices when a call first needs it: 8 MiB a matrix, and more than a machine has
/// for the largest robots, whose recursions need none.
const MATRICES_FROM_START: usize = 1024;

/// Scratch for the algorithms on one model, over one scalar.
///
/// Every algorithm writes what it reads: no call depends on what an earlier call left here, so one
/// workspace serves all algorithms in any order. One per thread.
///
/// For a robot of more than 1024 degrees of freedom, the first call that computes with a matrix of the workspace allocates it: the inverse
/// and the factor of M, forward dynamics by that factor, and the derivatives of forward dynamics.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar = f64> {
    /// Whose it is.
    pub(crate) robot: Identity,
    pub(crate) tree: TreeMemory<S>,
    pub(crate) dense: Dense<S>,
    /// Of the watch over the rank of M.
    pub(crate) rank: extent::Scratch,
    /// The newest instructions of the tree's memory, where there is no room for matrices yet.
    without_matrices: Option<InstructionSet>,
}

/// What an algorithm keeps of the recursions' results to compute with them.
#[derive(Clone, Debug)]
pub(crate) struct Dense<S> {
    /// nv×nv, row-major: M, then its factor. See [`Workspace::make_room_for_matrices`].
    pub(crate) matrix: Vec<S>,
    /// nv numbers.
    pub(crate) vector: Vec<S>,
    /// Twice nq numbers: a configuration and its rate.
    pub(crate) coordinates: Vec<S>,
    /// λ: the coordinate that carries each coordinate, or `sparse::NONE`.
    pub(crate) carrier: Vec<usize>,
}

impl<S: Scalar> Dense<S> {
    fn new(model: &Model, has_matrix: bool) -> Self {
        let zeros = |count: usize| vec![S::zero(); count];
        let (nq, nv) = (model.nq, model.nv);
        Self {
            matrix: zeros(if has_matrix { nv * nv } else { 0 }),
            vector: zeros(nv),
            coordinates: zeros(2 * nq),
            carrier: coordinate_carriers(model),
        }
    }
}

impl<S: Scalar> Workspace<S> {
    /// Memory for this model: the only allocation of the non-allocating calls.
    pub fn new(model: &Model) -> Self {
        Self::limited(model, InstructionSet::best())
    }

    /// As [`Workspace::new`], but its algorithms run on no newer instructions than these: to reproduce the results of a
    /// machine without the newer ones. They are the same to rounding; between AVX2 and AVX-512 they are the same bits.
    pub fn limited(model: &Model, limit: InstructionSet) -> Self {
        let has_matrices = model.nv <= MATRICES_FROM_START;
        let dense = Dense::new(model, has_matrices);
        let carrier = if has_matrices { &dense.carrier[..] } else { &[] };
        let tree = TreeMemory::limited(model, carrier, limit);
        Self { without_matrices: (!has_matrices).then_some(limit), ..Self::over(model, tree, dense) }
    }

    fn over(model: &Model, tree: TreeMemory<S>, dense: Dense<S>) -> Self {
        let rank = extent::Scratch::new(model);
        Self { robot: model.identity.clone(), tree, dense, rank, without_matrices: None }
    }

    /// Before a call computes with the workspace's matrices.
    #[inline(always)]
    pub(crate) fn make_room_for_matrices(&mut self, model: &Model) {
        if let Some(limit) = self.without_matrices {
            self.allocate_matrices(model, limit);
        }
    }

    #[cold]
    #[inline(never)]
    fn allocate_matrices(&mut self, model: &Model, limit: InstructionSet) {
        let tree = TreeMemory::limited(model, &self.dense.carrier, limit);
        let native = core::mem::replace(&mut self.tree, tree).native;
        self.tree.native = native;
        self.dense.matrix = vec![S::zero(); model.nv * model.nv];
        self.without_matrices = None;
    }

    /// Refuses another robot's workspace, and a q of another length: the first line of every call.
    #[inline(always)]
    #[track_caller]
    pub(crate) fn admit(&self, model: &Model, q: &[S]) {
        self.robot.check(model, "the workspace");
        check_length("q", q.len(), model.nq);
    }

    /// Memory of one number alone, as kernels compute with.
    #[cfg(feature = "batch")]
    pub(crate) fn scratch(model: &Model) -> Self {
        let dense = Dense::new(model, true);
        Self::over(model, TreeMemory::portable(model, &dense.carrier), dense)
    }

    /// The instructions that its recursions run on; where these are AVX2, derivatives may run on AVX-512.
    pub fn instruction_set(&self) -> InstructionSet {
        match self.tree.fast.as_ref().map(OneState::instruction_set) {
            None => InstructionSet::Portable,
            Some(InstructionSet::Avx512) => InstructionSet::Avx2,
            Some(set) => set,
        }
    }
}
