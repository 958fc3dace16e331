//! NVIDIA's devices, through CUDA and its run-time compiler.
//!
//! The tests of `generate` compile the same code as C++ and compare it with the library's bits; this module
//! adds the access to the device. The libraries are loaded when a device is opened.

mod cache;
mod compiler;
mod ffi;
mod launch;

use std::path::Path;
use std::sync::{Arc, Mutex};

use cudarc::driver::{CudaContext, CudaFunction, CudaStream, DriverError};
use cudarc::nvrtc::Ptx;
use robot_dynamics_generate::{GeneratedFiles, Precision, Target};

use self::compiler::Compiler;
pub use self::ffi::{CallerStream, DevicePointer};
use self::launch::{Buffer, Launch, locked};
use super::{Backend, CallerMemory, Command, TableCounts};
use crate::{DeviceError, Limits};

/// The default limit on the bytes of a table.
const MAX_BYTES: usize = 1 << 30;

/// The largest number of states of a launch, which the kernel counts with 32 bits.
const MAX_STATES: usize = 1 << 30;

/// A device, and the stream that executes its commands in order.
pub(crate) struct Cuda {
    name: String,
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    limits: Limits,
    compiler: Compiler,
}

/// A kernel, and the number of its tables.
pub(crate) struct Kernel {
    function: CudaFunction,
    tables: usize,
}

impl Cuda {
    /// Opens a device, with the run-time compiler at this path or where the system finds it.
    ///
    /// # Errors
    /// [`DeviceError::NoCuda`].
    pub(crate) fn open(ordinal: usize, limits: Limits, compiler: Option<&Path>) -> Result<Self, DeviceError> {
        ffi::find_driver().map_err(|cause| DeviceError::NoCuda { cause })?;
        let none = |error: DriverError| DeviceError::NoCuda { cause: format!("device {ordinal}: {error}") };
        let context = CudaContext::new(ordinal).map_err(none)?;
        let (major, minor) = context.compute_capability().map_err(none)?;
        let compiler = Compiler::find(compiler, 10 * major + minor);
        let compiler = compiler.map_err(|cause| DeviceError::NoCuda { cause })?;
        let name = format!("{}, CUDA {major}.{minor}", context.name().map_err(none)?);
        let stream = context.default_stream();
        Ok(Self { name, context, stream, limits, compiler })
    }

    fn failed(&self, error: &impl ToString) -> DeviceError {
        DeviceError::Failed { device: self.name.clone(), cause: error.to_string() }
    }
}

impl Backend for Cuda {
    type Buffer = Buffer;
    type Kernel = Kernel;
    type Launch = Launch;

    const TARGET: Target = Target::Cuda;

    fn name(&self) -> &str {
        &self.name
    }

    fn has(&self, _: Precision) -> bool {
        true
    }

    fn most_bytes(&self) -> usize {
        let asked = self.limits.table_bytes.and_then(|bytes| usize::try_from(bytes).ok());
        asked.unwrap_or(MAX_BYTES).min(MAX_BYTES)
    }

    fn most_states(&self) -> usize {
        self.limits.launch_states.unwrap_or(MAX_STATES).clamp(1, MAX_STATES)
    }

    fn compile(
        &self,
        generated: &GeneratedFiles,
        symbol: &str,
        tables: TableCounts,
    ) -> Result<Kernel, String> {
        let file = generated.file("robot.cu").ok_or("no kernels were generated")?;
        let code = Ptx::from_binary(self.compiler.compile(&file.text)?);
        let module = self.context.load_module(code).map_err(|error| error.to_string())?;
        let function = module.load_function(&format!("robot_{symbol}")).map_err(|error| error.to_string())?;
        Ok(Kernel { function, tables: tables.reads + tables.writes })
    }

    fn allocate(&self, bytes: usize) -> Result<Buffer, DeviceError> {
        let memory = self.stream.alloc_zeros(bytes).map_err(|error| {
            self.failed(&format!("{error} for {bytes} bytes; compute fewer states at once"))
        })?;
        Ok(Arc::new(Mutex::new(memory)))
    }

    fn write(&self, buffer: &Buffer, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut memory = locked(buffer);
        let mut start = memory.slice_mut(..bytes.len());
        self.stream.memcpy_htod(bytes, &mut start).map_err(|error| self.failed(&error))
    }

    fn read(&self, buffer: &Buffer, bytes: &mut [u8]) -> Result<(), DeviceError> {
        let memory = locked(buffer);
        self.stream.memcpy_dtoh(&memory.slice(..bytes.len()), bytes).map_err(|error| self.failed(&error))?;
        self.wait()
    }

    fn bind(&self, kernel: &Kernel, tables: &[(&Buffer, usize)], states: usize) -> Launch {
        assert!(tables.len() == kernel.tables, "{} tables for a kernel of {}", tables.len(), kernel.tables);
        for (buffer, bytes) in tables {
            let there = locked(buffer).len();
            assert!(states * bytes <= there, "a table of {there} bytes for {states} states of {bytes}");
        }
        let tables = tables.iter().map(|(buffer, _)| Arc::clone(buffer)).collect();
        let states = u32::try_from(states).expect("a launch has at most 2³⁰ states");
        Launch { kernel: kernel.function.clone(), tables, states }
    }

    fn submit(&self, commands: &[Command<'_, Self>]) -> Result<(), DeviceError> {
        for command in commands {
            let done = match command {
                Command::Run(launch) => ffi::launch(&self.stream, launch),
                Command::Copy { from, from_at, to, to_at, bytes } => {
                    let (from, mut to) = (locked(from), locked(to));
                    let mut there = to.slice_mut(*to_at..to_at + bytes);
                    self.stream.memcpy_dtod(&from.slice(*from_at..from_at + bytes), &mut there)
                }
            };
            done.map_err(|error| self.failed(&error))?;
        }
        Ok(())
    }

    fn run_on(&self, kernel: &Kernel, memory: &CallerMemory<'_>) -> Result<(), DeviceError> {
        let CallerMemory { stream, tables, states, by_columns } = *memory;
        assert!(tables.len() == kernel.tables, "{} tables for a kernel of {}", tables.len(), kernel.tables);
        let states = u32::try_from(states).expect("a launch has at most 2³⁰ states");
        ffi::launch_on(&self.context, stream, &kernel.function, tables, states, by_columns)
            .map_err(|error| self.failed(&error))
    }

    fn wait(&self) -> Result<(), DeviceError> {
        self.stream.synchronize().map_err(|error| self.failed(&error))
    }
}
