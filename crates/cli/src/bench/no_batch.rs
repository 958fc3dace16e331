//! In place of batches, where the program is built without them.

use core::marker::PhantomData;

use dynamics::{Integrator, Scalar};
use multibody::{FrameId, InstructionSet, Model, Quantity};

use super::states::States;
use crate::failure::Failure;

/// Nothing is measured of batches.
pub(super) const MEASURED: [Quantity; 0] = [];
pub(super) const ROLLOUTS: [Integrator; 0] = [];

/// What would be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(dead_code)]
pub(super) enum Work {
    Compute(Quantity),
    Rollout(Integrator),
}

/// No batch.
pub(super) struct Batch<'a, T>(PhantomData<(&'a Model, T)>);

#[allow(clippy::unused_self, clippy::unnecessary_wraps, clippy::needless_pass_by_value)] // as the batches
impl<'a, T: Scalar> Batch<'a, T> {
    pub(super) fn new(_: &'a Model, _: States<T>, _: FrameId, _: &[usize]) -> Result<Self, Failure> {
        Ok(Self(PhantomData))
    }

    pub(super) fn lanes(&self) -> (usize, InstructionSet) {
        (0, InstructionSet::Portable)
    }

    pub(super) fn block(&mut self, _: Work, _: usize, _: &mut usize) -> Result<usize, String> {
        Err("there are no batches in this build".into())
    }
}
