//! The threads of a batch and their memory.

use std::sync::{Mutex, MutexGuard, OnceLock};

use dynamics::{Float, Lanes, StateLanes};
use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

use super::block::Block;
use super::compiled_once::CompiledOnce;
use crate::dispatch::has_fused;
use crate::identity::Identity;
use crate::{InstructionSet, Model, Workspace};

/// A number that batches are computed in: `f64` or `f32`.
pub trait BatchFloat: Float + CompiledOnce {
    /// One: where no register holds more, the compiler does better with it than with several side by side.
    type Portable: StateLanes<Float = Self>;
    /// As many as one AVX2 register holds.
    type Narrow: StateLanes<Float = Self>;
    /// As many as one AVX-512 register holds.
    type Wide: StateLanes<Float = Self>;
}

impl BatchFloat for f64 {
    type Portable = f64;
    type Narrow = Lanes<f64, 4>;
    type Wide = Lanes<f64, 8>;
}

impl BatchFloat for f32 {
    type Portable = f32;
    type Narrow = Lanes<f32, 8>;
    type Wide = Lanes<f32, 16>;
}

/// How batches are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchOptions {
    /// Threads; 0 stands for one a core, shared by all such workspaces; 1 for the calling thread alone.
    pub threads: usize,
    /// Leaves AVX-512 unused, as on a machine without it; the results are the same bits.
    pub no_avx512: bool,
    /// Leaves AVX2, FMA and AVX-512 unused, as on a machine without them; the results are the same to rounding.
    pub portable: bool,
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
///
/// Without optimisation (`opt-level = 0`) a block takes up to 4 MiB of stack. The pools' threads have
/// that; a calling thread that computes itself may not (threads start with 2 MiB).
#[derive(Debug)]
pub struct BatchWorkspace<T: BatchFloat> {
    pool: Pool,
    pub(super) blocks: Blocks<T>,
    pub(super) robot: Identity,
}

#[derive(Debug)]
pub enum Pool {
    /// No pool: the calling thread.
    Caller,
    Shared(&'static ThreadPool),
    Own(ThreadPool),
}

/// Stack of a pool's thread: a block of an unoptimised build takes 3 MiB.
const STACK: usize = 16 << 20;

fn start(threads: usize) -> Result<ThreadPool, ThreadError> {
    let builder = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
    builder.build().map_err(|cause| ThreadError { threads, cause })
}

/// One thread a core, started when first asked for; none where the machine has no threads.
fn shared() -> Pool {
    static SHARED: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = SHARED.get_or_init(|| start(0).ok()).as_ref();
    pool.filter(|pool| pool.current_num_threads() > 1).map_or(Pool::Caller, Pool::Shared)
}

/// One block for each thread, of the lanes that this machine has.
#[derive(Debug)]
pub(super) enum Blocks<T: BatchFloat> {
    Portable(Vec<Mutex<Block<T::Portable>>>),
    Narrow(Vec<Mutex<Block<T::Narrow>>>),
    Wide(Vec<Mutex<Block<T::Wide>>>),
}

/// The same expression on the blocks, of whichever lanes they are.
macro_rules! on_blocks {
    ($all:expr, $blocks:ident => $result:expr) => {
        match $all {
            $crate::batch::workspace::Blocks::Portable($blocks) => $result,
            $crate::batch::workspace::Blocks::Narrow($blocks) => $result,
            $crate::batch::workspace::Blocks::Wide($blocks) => $result,
        }
    };
}
pub(super) use on_blocks;

impl<T: BatchFloat> BatchWorkspace<T> {
    /// Memory for this model, for one thread a core.
    pub fn new(model: &Model) -> Self {
        T::workspace(model, shared(), BatchOptions::default())
    }

    /// Memory for this model, with threads of its own if a number is given.
    ///
    /// # Errors
    /// [`ThreadError`] if the threads cannot be started.
    pub fn with_options(model: &Model, options: BatchOptions) -> Result<Self, ThreadError> {
        let pool = match options.threads {
            0 => shared(),
            1 => Pool::Caller,
            threads => Pool::Own(start(threads)?),
        };
        Ok(T::workspace(model, pool, options))
    }

    pub(super) fn on(model: &Model, pool: Pool, options: BatchOptions) -> Self {
        let threads = match &pool {
            Pool::Caller => 1,
            Pool::Shared(pool) => pool.current_num_threads(),
            Pool::Own(pool) => pool.current_num_threads(),
        };
        let BatchOptions { no_avx512, portable, .. } = options;
        let blocks = if portable || !has_fused::<T::Narrow>() {
            Blocks::Portable(for_each(threads, model, Workspace::portable))
        } else if no_avx512 || !has_fused::<T::Wide>() {
            Blocks::Narrow(for_each(threads, model, Workspace::without_avx512))
        } else {
            Blocks::Wide(for_each(threads, model, Workspace::new))
        };
        Self { pool, blocks, robot: model.identity.clone() }
    }

    /// How many threads compute.
    pub fn threads(&self) -> usize {
        on_blocks!(&self.blocks, blocks => blocks.len())
    }

    /// How many states one block holds.
    pub fn lanes(&self) -> usize {
        fn of<S: StateLanes>(_: &[Mutex<Block<S>>]) -> usize {
            S::LANES
        }
        on_blocks!(&self.blocks, blocks => of(blocks))
    }

    /// The instructions that the algorithms run on.
    pub fn instruction_set(&self) -> InstructionSet {
        // Every block is made alike, and a workspace has at least one.
        fn of<S: StateLanes>(blocks: &[Mutex<Block<S>>]) -> InstructionSet {
            own_block(blocks).workspace.instruction_set()
        }
        on_blocks!(&self.blocks, blocks => of(blocks))
    }

    /// Runs `call` where [`own_block`] finds this workspace's threads.
    pub(super) fn install<R: Send>(&self, call: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Pool::Caller => call(),
            Pool::Shared(pool) => pool.install(call),
            Pool::Own(pool) => pool.install(call),
        }
    }
}

/// A block for each thread.
fn for_each<S: StateLanes>(
    threads: usize,
    model: &Model,
    workspace: fn(&Model) -> Workspace<S>,
) -> Vec<Mutex<Block<S>>> {
    (0..threads).map(|_| Mutex::new(Block::new(model, workspace(model)))).collect()
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
