//! What no compiler checks: that libraries are CUDA's, and that a kernel gets the arguments that it was generated with.
//!
//! Unsafe code: three calls, each with its reason.
#![allow(unsafe_code)]

use cudarc::driver::{CudaStream, DriverError, LaunchConfig, PushKernelArg};

use super::{BLOCK, Launch, locked};

/// Whether the system finds the driver and the run-time compiler; else which one it does not.
pub(super) fn find_libraries() -> Result<(), String> {
    // SAFETY: a library by CUDA's name is opened as the calls after it would open it; what its start-up code does is the system's
    // word, as for every library that is linked.
    let (driver, compiler) =
        unsafe { (cudarc::driver::sys::is_culib_present(), cudarc::nvrtc::sys::is_culib_present()) };
    match (driver, compiler) {
        (false, _) => Err("the driver's library libcuda was not found".into()),
        (true, false) => Err("the run-time compiler's library libnvrtc was not found".into()),
        (true, true) => Ok(()),
    }
}

/// Puts a kernel on the stream.
pub(super) fn launch(stream: &CudaStream, launch: &Launch) -> Result<(), DriverError> {
    // No table is bound twice, so that no lock waits for itself.
    let tables: Vec<_> = launch.tables.iter().map(|table| locked(table)).collect();
    let (count, by_columns) = (i32::try_from(launch.states).expect("at most 2³⁰ states"), 0_i32);
    let mut arguments = stream.launch_builder(&launch.kernel);
    for table in &tables {
        arguments.arg(&**table);
    }
    arguments.arg(&count);
    arguments.arg(&by_columns);
    let blocks = launch.states.div_ceil(BLOCK);
    let shape = LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (BLOCK, 1, 1), shared_mem_bytes: 0 };
    // SAFETY: a generated kernel's parameters are a pointer to each table, the count of states and whether they are by columns, in
    // this order (`generate/src/target/cuda.rs`). Its threads beyond `count` return, the others read and write rows of their own,
    // and `bind` has seen that there are as many tables as it has, and that each holds so many states. The stream takes its commands one after the other, and memory is
    // given back on it.
    unsafe { arguments.launch(shape) }.map(|_| ())
}
