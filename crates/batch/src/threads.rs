//! Threads for batches.

use robot_dynamics_number::{Classified, ErrorKind};
use std::sync::{Arc, OnceLock};

use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

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

impl Classified for ThreadError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::System
    }
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
pub struct Threads(pub(super) Arc<ThreadPool>);

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
pub(super) fn shared() -> Pool {
    static SHARED: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = SHARED.get_or_init(|| start(0).ok()).as_ref();
    pool.filter(|pool| pool.current_num_threads() > 1).map_or(Pool::Caller, Pool::Shared)
}

/// Calls a function with sufficient stack for a block. Optimized builds always have it. Without optimization
/// a kernel stores every intermediate number and exceeds the default stack of threads, so each call starts
/// its own thread. WebAssembly has no threads; the linker determines its stack.
pub(super) fn on_enough_stack<R: Send>(call: impl FnOnce() -> R + Send) -> R {
    if cfg!(any(not(unoptimised), target_family = "wasm")) {
        return call();
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, call);
        let thread = thread.expect("a thread with a stack for an unoptimised block");
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
