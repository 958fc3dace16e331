//! The inputs of a rollout's pullback.

use crate::rollout::torques::Torques;

/// The inputs of a rollout's pullback.
pub struct PullbackInputs<'a, T> {
    pub(in crate::rollout) spacing: usize,
    pub(in crate::rollout) torques: Torques<'a, T>,
    pub(in crate::rollout) q: &'a [T],
    pub(in crate::rollout) v: &'a [T],
    pub(in crate::rollout) trajectory: (&'a [T], &'a [T]),
}
