//! Reports of the states in a batch without a valid result.

use robot_dynamics_number::{Classified, ErrorKind};
use std::sync::{Mutex, PoisonError};

use thiserror::Error;

/// The error if some states of a batch have no valid result; the results of all other states are valid.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{} of {batch} states are bad, the first is state {}: a number given or computed for it is not finite \
     (a NaN, an infinity, a zero quaternion, a singular mass matrix); its results are NaN, those of all \
     other states are valid",
    .states.len(),
    .states.first().copied().unwrap_or(0)
)]
#[non_exhaustive]
pub struct BadStates {
    /// The indices of these states in the batch, ascending.
    pub states: Vec<usize>,
    /// The number of states in the batch.
    pub batch: usize,
}

impl Classified for BadStates {
    fn kind(&self) -> ErrorKind {
        ErrorKind::InvalidInput
    }
}

impl BadStates {
    /// Returns an error that lists these states in order, without duplicates, or `Ok` for an empty list.
    /// For batches that are computed outside this crate.
    ///
    /// ```
    /// use robot_dynamics::batch::BadStates;
    /// assert_eq!(BadStates::unless_empty(vec![7, 2, 7], 10).unwrap_err().states, [2, 7]);
    /// assert!(BadStates::unless_empty(Vec::new(), 10).is_ok());
    /// ```
    ///
    /// # Errors
    /// `states` is not empty.
    pub fn unless_empty(mut states: Vec<usize>, batch: usize) -> Result<(), Self> {
        states.sort_unstable();
        states.dedup();
        if states.is_empty() { Ok(()) } else { Err(Self { states, batch }) }
    }
}

/// The bad states that the threads find.
#[derive(Default)]
pub(super) struct BadStateSet(Mutex<Vec<usize>>);

impl BadStateSet {
    /// Adds the states of a block's bad lanes, one bit each; the first lane holds state `first`.
    pub(super) fn add(&self, bits: u32, first: usize) {
        if bits != 0 {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(states_of(bits, first));
        }
    }

    /// Returns an error that lists them, if there are any.
    pub(super) fn into_result(self, batch: usize) -> Result<(), BadStates> {
        BadStates::unless_empty(self.0.into_inner().unwrap_or_else(PoisonError::into_inner), batch)
    }
}

/// The states of a block's bad lanes, one bit each; the first lane holds state `first`.
pub(super) fn states_of(bits: u32, first: usize) -> impl Iterator<Item = usize> {
    (0..u32::BITS as usize).filter(move |lane| bits >> lane & 1 == 1).map(move |lane| first + lane)
}
