//! The scratch memory of the algorithms; it belongs to the caller.

use dynamics::Scalar;
use number::dispatch::OneState;

use crate::factor::sparse::coordinate_carriers;
use crate::model::identity::Identity;
use crate::model::length::check_length;
use crate::scratch::extent;
use crate::scratch::tree::TreeMemory;
use crate::{InstructionSet, Model};

/// Scratch for the algorithms on one model, over one scalar.
///
/// Every algorithm writes what it reads: no call depends on what an earlier call left here, so one
/// workspace serves all algorithms in any order. One per thread.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar = f64> {
    /// Whose it is.
    pub(crate) robot: Identity,
    pub(crate) tree: TreeMemory<S>,
    pub(crate) dense: Dense<S>,
    /// Of the watch over the rank of M.
    pub(crate) rank: extent::Scratch,
}

/// What an algorithm keeps of the recursions' results to compute with them.
#[derive(Clone, Debug)]
pub(crate) struct Dense<S> {
    /// nv×nv, row-major: M, then its factor.
    pub(crate) matrix: Vec<S>,
    /// nv numbers.
    pub(crate) vector: Vec<S>,
    /// Twice nq numbers: a configuration and its rate.
    pub(crate) coordinates: Vec<S>,
    /// λ: the coordinate that carries each coordinate, or `sparse::NONE`.
    pub(crate) carrier: Vec<usize>,
}

impl<S: Scalar> Dense<S> {
    fn new(model: &Model) -> Self {
        let zeros = |count: usize| vec![S::zero(); count];
        let (nq, nv) = (model.nq, model.nv);
        Self {
            matrix: zeros(nv * nv),
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
        let dense = Dense::new(model);
        Self::over(model, TreeMemory::limited(model, &dense.carrier, limit), dense)
    }

    fn over(model: &Model, tree: TreeMemory<S>, dense: Dense<S>) -> Self {
        Self { robot: model.identity.clone(), tree, dense, rank: extent::Scratch::new(model) }
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
        let dense = Dense::new(model);
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
