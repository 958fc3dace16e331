//! The unchecked interface to CUDA: the identity of its libraries, and the arguments of kernels.
//!
//! Unsafe code: three calls, each with its reason.
#![allow(unsafe_code)]

use cudarc::driver::{CudaStream, DriverError, LaunchConfig, PushKernelArg};

use super::launch::{BLOCK, Launch, locked};

/// Checks that the system finds the driver and the run-time compiler; the error names the missing one.
pub(super) fn find_libraries() -> Result<(), String> {
    // SAFETY: libraries with CUDA's names are opened as the later calls would open them. Their start-up code
    // is trusted, as for every library that is linked.
    let (driver, compiler) =
        unsafe { (cudarc::driver::sys::is_culib_present(), cudarc::nvrtc::sys::is_culib_present()) };
    match (driver, compiler) {
        (false, _) => Err("the driver's library libcuda was not found".into()),
        (true, false) => Err("the run-time compiler's library libnvrtc was not found".into()),
        (true, true) => Ok(()),
    }
}

/// Launches a kernel on the stream.
pub(super) fn launch(stream: &CudaStream, launch: &Launch) -> Result<(), DriverError> {
    // No table is bound twice, so no lock is taken twice.
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
    // SAFETY: a generated kernel's parameters are a pointer to each table, the number of states and whether
    // they are by columns, in this order (`generate/src/writers/cuda.rs`). Threads beyond `count` return; the
    // others access rows of their own. `bind` has checked the number of tables and that each holds this
    // number of states. The stream executes its commands in order, and memory is freed on it.
    unsafe { arguments.launch(shape) }.map(|_| ())
}
