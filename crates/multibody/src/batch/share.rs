//! Several tables of results, cut into blocks of states over the threads.

use super::workspace::{BlockMemory, own_block};
use super::{BatchFloat, BatchWorkspace};

/// Calls `run` with each block: its memory, its first state, how many, and their rows of the results. `blocks` are taken by
/// a thread at once, at most. No allocation.
pub(super) fn for_each_block<T: BatchFloat, const K: usize>(
    workspace: &BatchWorkspace<T>,
    batch: usize,
    blocks: usize,
    results: [&mut [T]; K],
    run: &(impl Fn(&mut BlockMemory, usize, usize, [&mut [T]; K]) + Sync),
) {
    let (threads, lanes) = (workspace.threads(), workspace.lanes());
    let chunk = match threads {
        1 => batch,
        _ => (batch.div_ceil(lanes) / (4 * threads)).clamp(1, blocks) * lanes,
    };
    let sharing = Sharing { workspace, chunk, run };
    workspace.install(|| sharing.share(0, batch, results));
}

struct Sharing<'a, T: BatchFloat, R> {
    workspace: &'a BatchWorkspace<T>,
    chunk: usize,
    run: &'a R,
}

impl<T: BatchFloat, R> Sharing<'_, T, R> {
    /// The states in halves, until one is a chunk.
    fn share<const K: usize>(&self, first: usize, states: usize, results: [&mut [T]; K])
    where
        R: Fn(&mut BlockMemory, usize, usize, [&mut [T]; K]) + Sync,
    {
        if states <= self.chunk {
            self.run_states(first, states, results);
            return;
        }
        let half = (states / 2).next_multiple_of(self.chunk).min(states);
        let (near, far) = split(results, half, states);
        rayon::join(|| self.share(first, half, near), || self.share(first + half, states - half, far));
    }

    /// Some states by one thread, block by block.
    fn run_states<const K: usize>(&self, mut first: usize, mut states: usize, mut results: [&mut [T]; K])
    where
        R: Fn(&mut BlockMemory, usize, usize, [&mut [T]; K]) + Sync,
    {
        let block = &mut *own_block(&self.workspace.blocks);
        while states > 0 {
            let count = states.min(self.workspace.lanes());
            let (own, rest) = split(results, count, states);
            (self.run)(block, first, count, own);
            (first, states, results) = (first + count, states - count, rest);
        }
    }
}

/// The first of so many states' rows, and the others'.
fn split<T, const K: usize>(
    results: [&mut [T]; K],
    first: usize,
    states: usize,
) -> ([&mut [T]; K], [&mut [T]; K]) {
    let mut far = [(); K].map(|()| &mut [][..]);
    let mut far_rows = far.iter_mut();
    let near = results.map(|rows| {
        let at = rows.len() / states * first;
        let (near, rest) = rows.split_at_mut(at);
        if let Some(far) = far_rows.next() {
            *far = rest;
        }
        near
    });
    (near, far)
}
