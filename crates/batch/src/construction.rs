//! The construction of workspaces.

use robot_dynamics_core::Model;

use crate::threads::{Pool, shared};
use crate::{BatchFloat, BatchOptions, BatchWorkspace, ThreadError, Threads};

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
}
