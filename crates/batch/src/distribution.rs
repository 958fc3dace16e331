//! Division of result tables into blocks of states over the threads.

use std::sync::{Mutex, PoisonError};

use robot_dynamics_number::Float;

use crate::BatchWorkspace;
use crate::workspace::{BlockMemory, ThreadMemory};

/// Calls `run` for each block with its memory, its first state, the number of states, and their rows of the
/// results. A thread takes at most `blocks` blocks at once, and then the next ones.
pub(super) fn for_each_block<T: Float, const K: usize>(
    workspace: &BatchWorkspace<T>,
    batch: usize,
    blocks: usize,
    results: [&mut [T]; K],
    run: &(impl Fn(&mut BlockMemory, usize, usize, [&mut [T]; K]) + Sync),
) {
    let states = (workspace.lanes(), blocks);
    for_each_part(workspace, batch, states, results, &|memory, first, states, results| {
        run(&mut memory.block, first, states, results);
    });
}

/// As [`for_each_block`], for parts of `lanes` states; a thread takes at most `blocks` parts at once.
pub(super) fn for_each_part<T: Float, const K: usize>(
    workspace: &BatchWorkspace<T>,
    batch: usize,
    (lanes, blocks): (usize, usize),
    results: [&mut [T]; K],
    run: &(impl Fn(&mut ThreadMemory<T>, usize, usize, [&mut [T]; K]) + Sync),
) {
    let threads = workspace.threads();
    let chunk = match threads {
        1 => batch,
        _ => (batch.div_ceil(lanes) / (4 * threads)).clamp(1, blocks) * lanes,
    };
    let left = Mutex::new(ResultRows { first: 0, states: batch, results });
    workspace.on_each_thread(|memory| {
        // The lock is released before the rows are computed.
        let next = || left.lock().unwrap_or_else(PoisonError::into_inner).split_off(chunk);
        while let Some(mut rows) = next() {
            while let Some(ResultRows { first, states, results }) = rows.split_off(lanes) {
                run(memory, first, states, results);
            }
        }
    });
}

/// Calls `run` for each state with its rows of the results and the value that `memory` creates for the
/// thread. A thread takes one state at a time, which suits long computations.
pub(super) fn for_each_state<T: Float, M, const K: usize>(
    workspace: &BatchWorkspace<T>,
    batch: usize,
    results: [&mut [T]; K],
    memory: &(impl Fn() -> M + Sync),
    run: &(impl Fn(&mut M, usize, [&mut [T]; K]) + Sync),
) {
    let left = Mutex::new(ResultRows { first: 0, states: batch, results });
    workspace.on_each_thread(|_| {
        let next = || left.lock().unwrap_or_else(PoisonError::into_inner).split_off(1);
        let mut own = None;
        while let Some(ResultRows { first, results, .. }) = next() {
            run(own.get_or_insert_with(memory), first, results);
        }
    });
}

/// Some states' rows of the results.
struct ResultRows<'a, T, const K: usize> {
    first: usize,
    states: usize,
    results: [&'a mut [T]; K],
}

impl<T, const K: usize> ResultRows<'_, T, K> {
    /// Splits off the rows of the first states, at most `at_most`; `None` if none are left.
    fn split_off(&mut self, at_most: usize) -> Option<Self> {
        let states = at_most.min(self.states);
        if states == 0 {
            return None;
        }
        let results = self.results.each_mut().map(|rows| {
            let numbers = rows.len() / self.states * states;
            rows.split_off_mut(..numbers).unwrap_or_default()
        });
        let first = self.first;
        (self.first, self.states) = (first + states, self.states - states);
        Some(Self { first, states, results })
    }
}
