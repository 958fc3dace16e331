//! The threads of batches: pools of this process, by their size.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, TryLockError};

use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use robot_dynamics::batch::Threads;

/// A pool and the process that started it. A process that was forked has its parent's pools in memory, but
/// not their threads: it leaves them as they are and starts its own.
struct Pool {
    process: u32,
    threads: Threads,
}

static POOLS: Mutex<Vec<Pool>> = Mutex::new(Vec::new());

/// The number that `set_num_threads` chose; 0 for one thread per core.
static CHOSEN: AtomicUsize = AtomicUsize::new(0);

/// A pool of this process with this many running threads.
pub(crate) fn pool(count: usize) -> PyResult<Threads> {
    let process = std::process::id();
    let start = || Threads::start(count).map_err(|error| PyRuntimeError::new_err(error.to_string()));
    // Not `lock`: if another thread held the lock when this process was forked, it would never be released.
    for _ in 0..1000 {
        let mut pools = match POOLS.try_lock() {
            Ok(pools) => pools,
            Err(TryLockError::Poisoned(pools)) => pools.into_inner(),
            Err(TryLockError::WouldBlock) => {
                std::thread::yield_now();
                continue;
            }
        };
        if let Some(pool) = pools.iter().find(|pool| pool.process == process && pool.threads.count() == count)
        {
            return Ok(pool.threads.clone());
        }
        let threads = start()?;
        pools.push(Pool { process, threads: threads.clone() });
        return Ok(threads);
    }
    start()
}

/// The default number of threads of a batch.
pub(crate) fn default_count() -> usize {
    match CHOSEN.load(Ordering::Relaxed) {
        0 => std::thread::available_parallelism().map_or(1, core::num::NonZero::get),
        chosen => chosen,
    }
}

/// The argument `threads=`; `None` for the default.
pub(crate) fn count_of(threads: Option<&Bound<'_, PyAny>>) -> PyResult<Option<usize>> {
    let Some(threads) = threads else { return Ok(None) };
    let count: i64 = threads.extract().map_err(|_| {
        PyTypeError::new_err("threads must be a whole number, or None for the default (see num_threads)")
    })?;
    match usize::try_from(count) {
        Ok(count @ 1..=4096) => Ok(Some(count)),
        _ => Err(PyValueError::new_err(format!(
            "threads = {count} must be from 1 to 4096, or None for the default (see num_threads)"
        ))),
    }
}

/// The number of threads that compute a batch by default.
///
/// Returns
/// -------
/// int
///     One per core, or the number that `set_num_threads` chose.
///
/// Examples
/// --------
/// >>> rd.num_threads() >= 1
/// True
#[pyfunction]
pub(crate) fn num_threads() -> usize {
    default_count()
}

/// Chooses how many threads compute a batch by default.
///
/// Results are the same bits for any number of threads. Workers of a cluster are processes side by side and
/// should use one thread each.
///
/// Parameters
/// ----------
/// threads : int or None
///     Number of threads, from 1 to 4096; `None` for one per core.
///
/// Raises
/// ------
/// ValueError
///     The number is out of range.
/// TypeError
///     `threads` is not a whole number.
///
/// Examples
/// --------
/// >>> rd.set_num_threads(1)
/// >>> rd.num_threads()
/// 1
/// >>> rd.set_num_threads(None)
#[pyfunction]
#[pyo3(signature = (threads, /))]
pub(crate) fn set_num_threads(threads: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    CHOSEN.store(count_of(threads.as_ref())?.unwrap_or(0), Ordering::Relaxed);
    Ok(())
}
