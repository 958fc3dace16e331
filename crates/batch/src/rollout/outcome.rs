//! The outcome of each state of a rollout.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::error::RolloutError;
use crate::bad_states::BadStateSet;

/// The outcome of each state.
#[derive(Default)]
pub(super) struct StateOutcomes {
    bad: BadStateSet,
    unfinished: Mutex<Vec<usize>>,
}

impl StateOutcomes {
    /// Records a block that is complete or cancelled, with a bit for each bad state.
    pub(super) fn add(&self, bits: u32, finished: bool, states: Range<usize>) {
        if finished {
            self.bad.add(bits, states.start);
        } else {
            self.unfinished.lock().unwrap_or_else(PoisonError::into_inner).extend(states);
        }
    }

    /// The error, if a state is bad or unfinished.
    pub(super) fn into_result(self, batch: usize) -> Result<(), RolloutError> {
        let mut unfinished = self.unfinished.into_inner().unwrap_or_else(PoisonError::into_inner);
        if !unfinished.is_empty() {
            unfinished.sort_unstable();
            return Err(RolloutError::Cancelled { unfinished, batch });
        }
        Ok(self.bad.into_result(batch)?)
    }
}
