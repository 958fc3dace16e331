//! The threads of a batch and their memory.

use core::marker::PhantomData;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};
use robot_dynamics_core::Model;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_number::dispatch::LaneMemory;
use robot_dynamics_number::{Float, InstructionSet};
use thiserror::Error;

use super::block::{Maker, OverLanes};
use super::compiled_once::CompiledOnce;

/// A number type of batches: `f64` or `f32`.
pub trait BatchFloat: Float + CompiledOnce {}

impl BatchFloat for f64 {}

impl BatchFloat for f32 {}

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

/// The threads could not be started.
#[derive(Debug, Error)]
#[error("cannot start {threads} threads: {cause}; use fewer, or 0 for the shared pool")]
#[non_exhaustive]
pub struct ThreadError {
    /// The requested number of threads.
    pub threads: usize,
    /// The error of the thread pool.
    #[source]
    pub cause: rayon::ThreadPoolBuildError,
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
pub struct BatchWorkspace<T: BatchFloat> {
    pool: Pool,
    /// One for each thread, at least one, all alike.
    pub(super) memories: Vec<Mutex<ThreadMemory<T>>>,
    lanes: usize,
    instructions: InstructionSet,
    pub(super) robot: Identity,
    of: PhantomData<T>,
}

#[derive(Debug)]
pub enum Pool {
    /// No pool: the calling thread.
    Caller,
    Shared(&'static ThreadPool),
    Own(Threads),
}

/// Threads that workspaces of any model share, which avoids starting threads for each workspace. They also
/// determine when threads start: after a fork, a process has its parent's memory but none of its threads.
#[derive(Clone, Debug)]
pub struct Threads(Arc<ThreadPool>);

impl Threads {
    /// Starts `threads` threads; 0 selects one per core.
    ///
    /// ```
    /// use robot_dynamics::batch;
    /// use robot_dynamics::batch::{BatchWorkspace, Threads};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let threads = Threads::start(2)?;
    /// let (mut g, expected) = ([0.0; 3], -2.0 * 9.81 * 0.5);
    /// for mass in [2.0, 4.0] {
    ///     let model = Model::new(pendulum(mass, 0.5))?;
    ///     let mut workspace = BatchWorkspace::<f64>::on_threads(&model, &threads);
    ///     batch::gravity(&model, &mut workspace, &[0.0; 3], &mut g)?;
    ///     assert!(g.iter().all(|g| (g - expected * mass / 2.0).abs() < 1e-13));
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ThreadError`] if they cannot be started.
    pub fn start(threads: usize) -> Result<Self, ThreadError> {
        Ok(Self(Arc::new(start(threads)?)))
    }

    /// The number of threads.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs `call` on one of the threads; rayon's `join` and parallel iterators inside it use all of them.
    pub fn install<R: Send>(&self, call: impl FnOnce() -> R + Send) -> R {
        self.0.install(call)
    }
}

/// The stack of a pool's thread; a block of an unoptimized build takes 3 MiB.
const STACK: usize = 16 << 20;

fn start(threads: usize) -> Result<ThreadPool, ThreadError> {
    let builder = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
    builder.build().map_err(|cause| ThreadError { threads, cause })
}

/// One thread per core, started on first use; none if the platform has no threads.
fn shared() -> Pool {
    static SHARED: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = SHARED.get_or_init(|| start(0).ok()).as_ref();
    pool.filter(|pool| pool.current_num_threads() > 1).map_or(Pool::Caller, Pool::Shared)
}

/// A block with the lanes of this machine.
pub(super) type BlockMemory = LaneMemory<OverLanes>;

/// The memory of a thread.
#[derive(Debug)]
pub(super) struct ThreadMemory<T> {
    pub(super) block: BlockMemory,
    /// The scratch memory of machine code.
    #[cfg_attr(not(feature = "native"), allow(dead_code))]
    pub(super) native: Vec<T>,
}

impl<T: BatchFloat> BatchWorkspace<T> {
    /// Allocates memory for this model, with one thread per core.
    pub fn new(model: &Model) -> Self {
        T::workspace(model, shared(), BatchOptions::default())
    }

    /// Allocates memory for this model, with its own threads if a number is given.
    ///
    /// # Errors
    /// [`ThreadError`] if the threads cannot be started.
    pub fn with_options(model: &Model, options: BatchOptions) -> Result<Self, ThreadError> {
        let pool = match options.threads {
            0 => shared(),
            1 => Pool::Caller,
            threads => Pool::Own(Threads::start(threads)?),
        };
        Ok(T::workspace(model, pool, options))
    }

    /// Allocates memory for this model on running threads; see [`Threads::start`].
    pub fn on_threads(model: &Model, threads: &Threads) -> Self {
        T::workspace(model, Pool::Own(threads.clone()), BatchOptions::default())
    }

    pub(super) fn on(model: &Model, pool: Pool, options: BatchOptions) -> Self {
        let threads = match &pool {
            Pool::Caller => 1,
            Pool::Shared(pool) => pool.current_num_threads(),
            Pool::Own(threads) => threads.count(),
        };
        let limit = options.limit.unwrap_or_else(InstructionSet::best);
        let block = || LaneMemory::new::<T>(limit, &Maker(model));
        let first = block();
        let (lanes, instructions) = (first.lanes(), first.instruction_set());
        let others = (1..threads).map(|_| block());
        let memory = |block| Mutex::new(ThreadMemory { block, native: Vec::new() });
        let memories = core::iter::once(first).chain(others).map(memory).collect();
        Self { pool, memories, lanes, instructions, robot: model.identity.clone(), of: PhantomData }
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

/// Calls a function with sufficient stack for a block. Optimized builds always have it. Without optimization
/// a kernel stores every intermediate number and exceeds the default stack of threads, so each call starts
/// its own thread. WebAssembly has no threads; the linker determines its stack.
fn on_enough_stack<R: Send>(call: impl FnOnce() -> R + Send) -> R {
    if cfg!(any(not(unoptimised), target_family = "wasm")) {
        return call();
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, call);
        let thread = thread.expect("a thread with a stack for an unoptimised block");
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
