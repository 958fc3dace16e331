//! The threads of a batch and their memory.

use core::marker::PhantomData;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use number::dispatch::LaneMemory;
use number::{Float, InstructionSet};
use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

use super::block::{Maker, OverLanes};
use super::compiled_once::CompiledOnce;
use crate::Model;
use crate::model::identity::Identity;

/// A number that batches are computed in: `f64` or `f32`.
pub trait BatchFloat: Float + CompiledOnce {}

impl BatchFloat for f64 {}

impl BatchFloat for f32 {}

/// How batches are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchOptions {
    /// Threads; 0 stands for one a core, shared by all such workspaces; 1 for the calling thread alone.
    pub threads: usize,
    /// The newest instructions to use, if not the newest that the machine has: to reproduce the results of a machine
    /// without the newer ones. They are the same to rounding; between AVX2 and AVX-512 they are the same bits.
    pub limit: Option<InstructionSet>,
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
/// With one thread a call allocates nothing unless it has bad states to report. With several, the calling one works,
/// too, and the others are told by a few words of allocated memory, independent of the batch's size.
///
/// Any stack will do. Without optimisation (`opt-level = 0`) a block takes up to 4 MiB of it: the pools' threads have
/// that, and for a calling thread that would compute itself one is started at each call.
#[derive(Debug)]
pub struct BatchWorkspace<T: BatchFloat> {
    pool: Pool,
    /// One for each thread, at least one, all made alike.
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

/// Threads that workspaces of any model share: to start them once where there are many workspaces, and to choose when,
/// as a process does that was forked: it has its parent's memory and none of its threads.
#[derive(Clone, Debug)]
pub struct Threads(Arc<ThreadPool>);

impl Threads {
    /// Starts so many threads; 0 stands for one a core.
    ///
    /// ```
    /// use multibody::batch::{self, BatchWorkspace, Threads};
    /// use multibody::{Model, pendulum};
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

    /// How many.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs `call` on one of them: rayon's `join` and parallel iterators within it use them all.
    pub fn install<R: Send>(&self, call: impl FnOnce() -> R + Send) -> R {
        self.0.install(call)
    }
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

/// A block of the lanes that this machine has.
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
            threads => Pool::Own(Threads::start(threads)?),
        };
        Ok(T::workspace(model, pool, options))
    }

    /// Memory for this model on threads that run already; see [`Threads::start`].
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

    /// How many threads compute.
    pub fn threads(&self) -> usize {
        self.memories.len()
    }

    /// How many states one block holds.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// The instructions that the algorithms run on.
    pub fn instruction_set(&self) -> InstructionSet {
        self.instructions
    }

    /// Runs `work` on the calling thread and, at the same time, on the pool's other threads, each with its own memory.
    ///
    /// The caller does not wait for a thread to wake: on a virtual machine that takes up to a millisecond. One that comes
    /// late finds less left to do.
    pub(super) fn on_each_thread(&self, work: impl Fn(&mut ThreadMemory<T>) + Sync) {
        let run = |k: usize| {
            // A block is all scratch: what a panic left in it is overwritten.
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

/// Calls where a block has room. Optimised, that is anywhere; without optimisation a kernel keeps every intermediate
/// number, more than threads have by default, so that a thread of its own is started for each call. WebAssembly has no threads;
/// there the stack is what the program was linked with.
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
