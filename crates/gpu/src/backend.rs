//! What a device must be able to do: memory, kernels, and commands in their order.

#[cfg(feature = "cuda")]
pub(crate) mod cuda;
#[cfg(feature = "wgpu")]
pub(crate) mod wgpu;

use generate::{Generated, Precision, Target};

use crate::DeviceError;

/// A device.
pub(crate) trait Backend: Send + Sync + Sized {
    /// Memory of the device.
    type Buffer: Send;
    /// A compiled function.
    type Kernel: Send;
    /// A kernel with the tables that it reads and writes, for so many states.
    type Launch: Send;

    fn name(&self) -> &str;

    /// The language of its kernels.
    const TARGET: Target;

    /// Whether it computes in this precision.
    fn has(&self, precision: Precision) -> bool;

    /// Bytes that one table may have.
    fn most_bytes(&self) -> usize;

    /// States that one launch may have.
    fn most_states(&self) -> usize;

    /// One of the functions that were generated, by its symbol, as `robot_{symbol}`; so many tables, of which it reads the first.
    ///
    /// # Errors
    /// What the device's compiler says.
    fn compile(&self, generated: &Generated, symbol: &str, tables: Tables) -> Result<Self::Kernel, String>;

    fn allocate(&self, bytes: usize) -> Result<Self::Buffer, DeviceError>;

    /// From the processor, at the buffer's start.
    fn write(&self, buffer: &Self::Buffer, bytes: &[u8]) -> Result<(), DeviceError>;

    /// To the processor, from the buffer's start, when all commands are done.
    fn read(&self, buffer: &Self::Buffer, bytes: &mut [u8]) -> Result<(), DeviceError>;

    /// Tables, with the bytes that one state has in each.
    fn bind(&self, kernel: &Self::Kernel, tables: &[(&Self::Buffer, usize)], states: usize) -> Self::Launch;

    /// Commands, each done after those before it.
    fn submit(&self, commands: &[Command<'_, Self>]) -> Result<(), DeviceError>;

    /// Returns when all is done.
    fn wait(&self) -> Result<(), DeviceError>;
}

/// How many tables a kernel reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tables {
    pub(crate) reads: usize,
    pub(crate) writes: usize,
}

/// A command.
pub(crate) enum Command<'a, B: Backend> {
    Run(&'a B::Launch),
    Copy { from: &'a B::Buffer, from_at: usize, to: &'a B::Buffer, to_at: usize, bytes: usize },
}
