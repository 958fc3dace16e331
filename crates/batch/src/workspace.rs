//! The memory of the threads of a batch.

use core::marker::PhantomData;
use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;
use robot_dynamics_core::Model;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_number::dispatch::LaneMemory;
use robot_dynamics_number::{Float, InstructionSet};

use crate::block::BlockStorage;
use crate::threads::{Pool, Threads, on_enough_stack};

/// Options of batch computations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchOptions {
    /// The number of threads. 0 selects one per core, shared by all such workspaces; 1 selects the calling
    /// thread alone.
    pub threads: usize,
    /// The newest instruction set to use, if not the newest of the machine, to reproduce results of an older
    /// machine. Results agree to rounding; those of AVX2 and AVX-512 are the same bits.
    pub limit: Option<InstructionSet>,
}

/// Scratch of every thread for batches on one model. It may serve any function of [`batch`](crate), in any
/// order, for batches of any size.
///
/// With one thread a call does not allocate unless it reports bad states. With several threads, the calling
/// thread works too, and starting the others allocates a few words, independent of the batch's size.
///
/// Any stack size is sufficient. Without optimization (`opt-level = 0`) a block takes up to 4 MiB of stack.
/// Threads of pools have that; a calling thread that would compute by itself starts a new thread for each
/// call.
#[derive(Debug)]
pub struct BatchWorkspace<T> {
    pool: Pool,
    /// One for each thread, at least one, all alike.
    memories: Vec<Mutex<ThreadMemory<T>>>,
    lanes: usize,
    instructions: InstructionSet,
    robot: Identity,
    of: PhantomData<T>,
}

/// A block with the lanes of this machine.
pub(super) type BlockMemory = LaneMemory<BlockStorage>;

/// The memory of a thread.
#[derive(Debug)]
pub(super) struct ThreadMemory<T> {
    pub(super) block: BlockMemory,
    /// The scratch memory of machine code.
    #[cfg_attr(not(feature = "native"), allow(dead_code))]
    pub(super) native: Vec<T>,
}

impl<T: Float> BatchWorkspace<T> {
    /// Memory for this model on these threads.
    pub(super) fn on(model: &Model, pool: Pool, options: BatchOptions) -> Self {
        let threads = match &pool {
            Pool::Caller => 1,
            Pool::Shared(pool) => pool.current_num_threads(),
            Pool::Own(threads) => threads.count(),
        };
        let limit = options.limit.unwrap_or_else(InstructionSet::best);
        let block = || LaneMemory::new::<T>(limit, model);
        let first = block();
        let (lanes, instructions) = (first.lanes(), first.instruction_set());
        let others = (1..threads).map(|_| block());
        let memory = |block| Mutex::new(ThreadMemory { block, native: Vec::new() });
        let memories = core::iter::once(first).chain(others).map(memory).collect();
        Self { pool, memories, lanes, instructions, robot: model.identity.clone(), of: PhantomData }
    }

    /// Panics if the workspace belongs to another model.
    #[track_caller]
    pub(super) fn check(&self, model: &Model) {
        model.check_identity(&self.robot, "the batch's workspace");
    }

    /// The number of threads.
    pub fn threads(&self) -> usize {
        self.memories.len()
    }

    /// The number of states in one block.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// The instruction set of the algorithms.
    pub fn instruction_set(&self) -> InstructionSet {
        self.instructions
    }

    /// Runs `work` on the calling thread and on the pool's other threads in parallel, each with its own
    /// memory.
    ///
    /// The caller does not wait for threads to wake up, which takes up to a millisecond on a virtual machine.
    /// A late thread takes part in the remaining work.
    pub(super) fn on_each_thread(&self, work: impl Fn(&mut ThreadMemory<T>) + Sync) {
        let run = |k: usize| {
            // All of a block is scratch, so data of a panicked call are overwritten.
            work(&mut self.memories[k].lock().unwrap_or_else(PoisonError::into_inner));
        };
        let pool: &ThreadPool = match &self.pool {
            Pool::Caller => return on_enough_stack(|| run(0)),
            Pool::Shared(pool) => pool,
            Pool::Own(Threads(pool)) => pool,
        };
        pool.in_place_scope(|scope| {
            for k in 1..self.threads() {
                scope.spawn(move |_| run(k));
            }
            on_enough_stack(|| run(0));
        });
    }
}
