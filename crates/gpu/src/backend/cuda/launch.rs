//! A kernel with its tables.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cudarc::driver::{CudaFunction, CudaSlice};

/// Threads of a block: few, because straight-line code uses many registers.
pub(super) const BLOCK: u32 = 128;

/// Memory of the device.
pub(crate) type Buffer = Arc<Mutex<CudaSlice<u8>>>;

/// A kernel with its tables.
pub(crate) struct Launch {
    pub(super) kernel: CudaFunction,
    pub(super) tables: Vec<Buffer>,
    pub(super) states: u32,
}

/// The content of a lock.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // After a panic the module or buffer is still valid.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
