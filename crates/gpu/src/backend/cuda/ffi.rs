//! The unchecked interface to CUDA: the identity of its libraries, the arguments of kernels, and memory and
//! streams of the caller.
//!
//! Unsafe code: each use has its reason.
#![allow(unsafe_code)]

pub(super) mod nvrtc;

use std::sync::Arc;

use cudarc::driver::{CudaContext, CudaFunction, CudaStream, DriverError, LaunchConfig, PushKernelArg, sys};

use super::launch::{BLOCK, Launch, locked};

/// Memory on a CUDA device that the caller owns: its address and its count of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DevicePointer {
    address: u64,
    numbers: usize,
}

impl DevicePointer {
    /// Memory with this count of numbers at this address.
    ///
    /// # Safety
    /// The memory is on the device that it is used with, and holds this count of numbers of the type that the
    /// functions were compiled for. It stays allocated until the stream has executed the commands that got
    /// it. Other code accesses it only in the order of that stream.
    pub const unsafe fn new(address: u64, numbers: usize) -> Self {
        Self { address, numbers }
    }

    /// The address.
    pub const fn address(&self) -> u64 {
        self.address
    }

    /// The count of numbers.
    pub const fn numbers(&self) -> usize {
        self.numbers
    }

    /// A pointer for tests that access no memory.
    #[cfg(test)]
    pub(crate) const fn of_test(address: u64, numbers: usize) -> Self {
        Self { address, numbers }
    }

    /// The part with the k-th `numbers` of it.
    pub(crate) fn part(&self, k: usize, numbers: usize, bytes: usize) -> Self {
        assert!((k + 1) * numbers <= self.numbers, "a part of {} numbers", self.numbers);
        Self { address: self.address + (k * numbers * bytes) as u64, numbers }
    }
}

/// A stream of CUDA that the caller owns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CallerStream {
    handle: u64,
}

impl CallerStream {
    /// The default stream of the device.
    pub const DEFAULT: Self = Self { handle: 0 };

    /// The stream with this handle, a `CUstream` or `cudaStream_t`: 0 or 1 for the default stream, 2 for that
    /// of the calling thread.
    ///
    /// # Safety
    /// The handle is 0, 1, 2, or that of a stream of the device's primary context that exists during each
    /// call that gets it.
    pub const unsafe fn from_handle(handle: u64) -> Self {
        Self { handle }
    }
}

/// Checks that the system finds the driver.
pub(super) fn find_driver() -> Result<(), String> {
    // SAFETY: libraries with the driver's names are opened as the later calls would open them. Their start-up
    // code is trusted, as for every library that is linked.
    let is_there = unsafe { cudarc::driver::sys::is_culib_present() };
    if is_there { Ok(()) } else { Err("the driver's library libcuda was not found".into()) }
}

/// The shape of a launch for this number of states.
fn shape(states: u32) -> LaunchConfig {
    LaunchConfig { grid_dim: (states.div_ceil(BLOCK), 1, 1), block_dim: (BLOCK, 1, 1), shared_mem_bytes: 0 }
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
    // SAFETY: a generated kernel's parameters are a pointer to each table, the number of states and whether
    // they are by columns, in this order (`generate/src/writers/cuda.rs`). Threads beyond `count` return; the
    // others access rows of their own. `bind` has checked the number of tables and that each holds this
    // number of states. The stream executes its commands in order, and memory is freed on it.
    unsafe { arguments.launch(shape(launch.states)) }.map(|_| ())
}

/// Launches a kernel on memory and on a stream of the caller. Each pointer holds the table of this number of
/// states, by rows or by columns.
pub(super) fn launch_on(
    context: &Arc<CudaContext>,
    stream: CallerStream,
    kernel: &CudaFunction,
    tables: &[DevicePointer],
    states: u32,
    by_columns: bool,
) -> Result<(), DriverError> {
    // SAFETY: by the contract of `CallerStream::from_handle` the stream exists during this call. The wrapper
    // does not outlive the call and does not destroy the stream.
    let stream = unsafe { context.wrap_borrowed_stream(stream.handle as sys::CUstream) };
    let (count, by_columns) = (i32::try_from(states).expect("at most 2³⁰ states"), i32::from(by_columns));
    let mut arguments = stream.launch_builder(kernel);
    for table in tables {
        arguments.arg(&table.address);
    }
    arguments.arg(&count);
    arguments.arg(&by_columns);
    // SAFETY: the parameters are those of `launch`. The caller of this function has checked that each table
    // holds this number of states and that no written table overlaps another. By the contract of
    // `DevicePointer::new` the memory is there until the stream has executed the kernel.
    unsafe { arguments.launch(shape(states)) }.map(|_| ())
}
