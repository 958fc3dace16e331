//! The inputs of a rollout's pullback.

use robot_dynamics_simulation::TrajectoryCotangents;

use crate::rollout::torques::Torques;

/// The inputs of [`rollout_pullback`](crate::rollout_pullback).
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations)] // torques can be a function
pub struct RolloutPullbackInputs<'a, T> {
    /// The number of steps between checkpoints; 0 selects √steps.
    pub spacing: usize,
    /// The torques of the rollout.
    pub torques: Torques<'a, T>,
    /// The initial configurations, \[batch\]\[nq\].
    pub q: &'a [T],
    /// The initial velocities, \[batch\]\[nv\].
    pub v: &'a [T],
    /// The gradients by the recorded states, \[batch\]\[samples\]\[nv\] each; empty without a stride.
    pub trajectory: TrajectoryCotangents<'a, T>,
}
