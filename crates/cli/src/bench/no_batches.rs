//! Stubs that replace `batch` in a build without the feature.

use core::marker::PhantomData;

use robot_dynamics::model::{FrameId, InstructionSet, Model};
use robot_dynamics::quantity::Quantity;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_number::Scalar;

use super::states::States;
use crate::failure::Failure;

/// No quantity is measured in batches.
pub(super) const QUANTITIES: [Quantity; 0] = [];
pub(super) const ROLLOUTS: [Integrator; 0] = [];

/// As in `batch`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(dead_code)]
pub(super) enum Work {
    Compute(Quantity),
    Rollout(Integrator),
}

/// As in `batch`.
pub(super) struct Batch<'a, T>(PhantomData<(&'a Model, T)>);

#[allow(clippy::unused_self, clippy::unnecessary_wraps, clippy::needless_pass_by_value)] // as in `batch`
impl<'a, T: Scalar> Batch<'a, T> {
    pub(super) fn new(_: &'a Model, _: States<T>, _: FrameId, _: &[usize]) -> Result<Self, Failure> {
        Ok(Self(PhantomData))
    }

    pub(super) fn lanes(&self) -> (usize, InstructionSet) {
        (0, InstructionSet::Portable)
    }

    pub(super) fn block(&mut self, _: Work, _: usize, _: &mut usize) -> Result<usize, String> {
        Err("this build has no batches".into())
    }
}
