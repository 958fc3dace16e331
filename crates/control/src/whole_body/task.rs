//! A task: an objective with its weight and level.

use super::objective::Objective;

/// An objective with its weight and level.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) objective: Objective,
    pub(super) weight: f64,
    pub(super) level: usize,
}
