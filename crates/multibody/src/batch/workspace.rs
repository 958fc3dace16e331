//! The threads of a batch and their memory.

use std::sync::{Mutex, MutexGuard};

use dynamics::{Float, Lanes, StateLanes};
use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

use super::block::Block;
use crate::Model;
use crate::dispatch::has_fused;

/// A number that batches are computed in: `f64` or `f32`.
pub trait BatchFloat: Float {
    /// As many as one AVX2 register holds.
    type Narrow: StateLanes<Float = Self>;
    /// As many as one AVX-512 register holds.
    type Wide: StateLanes<Float = Self>;
}

impl BatchFloat for f64 {
    type Narrow = Lanes<f64, 4>;
    type Wide = Lanes<f64, 8>;
}

impl BatchFloat for f32 {
    type Narrow = Lanes<f32, 8>;
    type Wide = Lanes<f32, 16>;
}

/// How batches are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchOptions {
    /// Threads; 0 stands for one a core (rayon's global pool), 1 for the calling thread alone.
    pub threads: usize,
    /// Leaves AVX-512 unused, as on a machine without it; the results are the same bits.
    pub no_avx512: bool,
}

/// The threads could not be started.
#[derive(Debug, Error)]
#[error("cannot start {threads} threads: {cause}; use fewer, or 0 for the shared pool")]
#[non_exhaustive]
pub struct ThreadError {
    /// How many were asked for.
    pub threads: usize,
    /// What the pool says.
    #[source]
    pub cause: rayon::ThreadPoolBuildError,
}

/// Scratch of every thread for batches on one model; it may serve any function of [`batch`](crate::batch),
/// in any order, for batches of any size.
///
/// With one thread a call allocates nothing unless it has bad states to report. With several, the pool may
/// allocate room for its queue, independent of the batch's size.
#[derive(Debug)]
pub struct BatchWorkspace<T: BatchFloat> {
    /// `None`: rayon's current pool, or the calling thread if there is one worker.
    pool: Option<ThreadPool>,
    pub(super) blocks: Blocks<T>,
    pub(super) dimensions: (usize, usize),
}

/// One block for each thread, of the lanes that this machine has.
#[derive(Debug)]
pub(super) enum Blocks<T: BatchFloat> {
    Narrow(Vec<Mutex<Block<T::Narrow>>>),
    Wide(Vec<Mutex<Block<T::Wide>>>),
}

impl<T: BatchFloat> BatchWorkspace<T> {
    /// Memory for this model, for as many threads as rayon's current pool has.
    pub fn new(model: &Model) -> Self {
        Self::on(model, None, rayon::current_num_threads(), false)
    }

    /// Memory for this model, with threads of its own if a number is given.
    ///
    /// # Errors
    /// [`ThreadError`] if the threads cannot be started.
    pub fn with_options(model: &Model, options: BatchOptions) -> Result<Self, ThreadError> {
        let BatchOptions { threads, no_avx512 } = options;
        let pool = match threads {
            0 | 1 => None,
            _ => Some(
                ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .map_err(|cause| ThreadError { threads, cause })?,
            ),
        };
        let count = if threads == 0 { rayon::current_num_threads() } else { threads };
        Ok(Self::on(model, pool, count, no_avx512))
    }

    fn on(model: &Model, pool: Option<ThreadPool>, threads: usize, no_avx512: bool) -> Self {
        let blocks = if has_fused::<T::Wide>() && !no_avx512 {
            Blocks::Wide((0..threads).map(|_| Mutex::new(Block::new(model))).collect())
        } else {
            Blocks::Narrow((0..threads).map(|_| Mutex::new(Block::new(model))).collect())
        };
        Self { pool, blocks, dimensions: (model.nq, model.nv) }
    }

    /// How many threads compute.
    pub fn threads(&self) -> usize {
        match &self.blocks {
            Blocks::Narrow(blocks) => blocks.len(),
            Blocks::Wide(blocks) => blocks.len(),
        }
    }

    /// How many states one block holds.
    pub fn lanes(&self) -> usize {
        match &self.blocks {
            Blocks::Narrow(_) => T::Narrow::LANES,
            Blocks::Wide(_) => T::Wide::LANES,
        }
    }

    /// Runs `call` where [`own_block`] finds this workspace's threads.
    pub(super) fn install<R: Send>(&self, call: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(call),
            None => call(),
        }
    }
}

/// The block of the thread that asks, or any that is free.
pub(super) fn own_block<S: StateLanes>(blocks: &[Mutex<Block<S>>]) -> MutexGuard<'_, Block<S>> {
    let own = rayon::current_thread_index().unwrap_or(0);
    let free = (0..blocks.len()).find_map(|k| blocks[(own + k) % blocks.len()].try_lock().ok());
    // A block is all scratch: what a panic left in it is overwritten.
    free.unwrap_or_else(|| {
        blocks[own % blocks.len()].lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    })
}
