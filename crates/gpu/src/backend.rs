//! The interface of a device: memory, kernels, and commands in order.

#[cfg(feature = "cuda")]
pub(crate) mod cuda;
#[cfg(feature = "wgpu")]
pub(crate) mod wgpu;

use robot_dynamics_generate::{GeneratedFiles, Precision, Target};

use crate::DeviceError;

/// A device.
pub(crate) trait Backend: Send + Sync + Sized + 'static {
    /// Memory of the device.
    type Buffer: Send + Sync + 'static;
    /// A compiled function.
    type Kernel: Send + Sync;
    /// A kernel with its tables, for a number of states.
    type Launch: Send;

    fn name(&self) -> &str;

    /// The language of its kernels.
    const TARGET: Target;

    /// Whether it supports this precision.
    fn has(&self, precision: Precision) -> bool;

    /// The largest table, in bytes.
    fn most_bytes(&self) -> usize;

    /// The largest number of states of one launch.
    fn most_states(&self) -> usize;

    /// Compiles the generated function with this symbol, named `robot_{symbol}`. It has this number of
    /// tables, of which it reads the first ones.
    ///
    /// # Errors
    /// The message of the device's compiler.
    fn compile(
        &self,
        generated: &GeneratedFiles,
        symbol: &str,
        tables: TableCounts,
    ) -> Result<Self::Kernel, String>;

    fn allocate(&self, bytes: usize) -> Result<Self::Buffer, DeviceError>;

    /// Copies bytes from the host to the start of the buffer.
    fn write(&self, buffer: &Self::Buffer, bytes: &[u8]) -> Result<(), DeviceError>;

    /// Copies bytes from the start of the buffer to the host, after all commands.
    fn read(&self, buffer: &Self::Buffer, bytes: &mut [u8]) -> Result<(), DeviceError>;

    /// Binds tables to a kernel, each with the bytes of one state.
    fn bind(&self, kernel: &Self::Kernel, tables: &[(&Self::Buffer, usize)], states: usize) -> Self::Launch;

    /// Submits commands, each executed after those before it.
    fn submit(&self, commands: &[Command<'_, Self>]) -> Result<(), DeviceError>;

    /// Runs a kernel on memory and on a stream of the caller.
    #[cfg(feature = "cuda")]
    fn run_on(&self, _: &Self::Kernel, _: &CallerMemory<'_>) -> Result<(), DeviceError> {
        Err(DeviceError::NoPointers { device: self.name().into() })
    }

    /// Waits until all commands are done.
    fn wait(&self) -> Result<(), DeviceError>;
}

/// The number of tables that a kernel reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableCounts {
    pub(crate) reads: usize,
    pub(crate) writes: usize,
}

/// The tables of a kernel in memory of the caller, and the stream that runs it.
#[cfg(feature = "cuda")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct CallerMemory<'a> {
    pub(crate) stream: cuda::CallerStream,
    pub(crate) tables: &'a [cuda::DevicePointer],
    pub(crate) states: usize,
    /// Whether one number of all states lies side by side, instead of all numbers of one state.
    pub(crate) by_columns: bool,
}

/// A command.
pub(crate) enum Command<'a, B: Backend> {
    Run(&'a B::Launch),
    Copy { from: &'a B::Buffer, from_at: usize, to: &'a B::Buffer, to_at: usize, bytes: usize },
}
