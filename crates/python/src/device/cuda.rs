//! CUDA devices, for arrays that other libraries hold on them.

use std::path::PathBuf;

use pyo3::prelude::*;
use robot_dynamics_generate::{Function, FunctionError};
use robot_dynamics_gpu::{Batches, Device, DeviceError, DeviceRollout, Limits, TableOrder};

use super::{device_exception, functions_of};
use crate::errors::exception;
use crate::ffi::device::{RawPointer, RawPointers, caller_stream, pointers};
use crate::robot::Robot;

/// A CUDA device.
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct CudaDevice {
    device: Device,
}

#[pymethods]
impl CudaDevice {
    /// Opens a device by its number, with the library of NVRTC at this path, or where the system finds it.
    #[new]
    #[pyo3(signature = (ordinal, compiler=None))]
    fn new(py: Python<'_>, ordinal: usize, compiler: Option<PathBuf>) -> PyResult<Self> {
        let open = || match compiler {
            Some(path) => Device::open_cuda_with_compiler(ordinal, Limits::default(), path),
            None => Device::open_cuda(ordinal, Limits::default()),
        };
        py.detach(open).map(|device| Self { device }).map_err(device_exception)
    }

    /// Name of the device.
    #[getter]
    fn name(&self) -> &str {
        self.device.name()
    }

    /// Compiles functions of a robot.
    #[pyo3(signature = (robot, functions, single))]
    fn _compile(
        &self,
        robot: &Bound<'_, Robot>,
        functions: Vec<String>,
        single: bool,
    ) -> PyResult<CudaFunctions> {
        let (functions, model) = (functions_of(&functions)?, &robot.get().model);
        let compiled = robot.py().detach(|| {
            Ok(if single {
                CompiledBatches::F32(self.device.compile(model, &functions)?)
            } else {
                CompiledBatches::F64(self.device.compile(model, &functions)?)
            })
        });
        compiled.map(|compiled| CudaFunctions { compiled }).map_err(device_exception)
    }
}

#[derive(Debug)]
enum CompiledBatches {
    F32(Batches<f32>),
    F64(Batches<f64>),
}

/// Functions of a robot that are compiled for a CUDA device.
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct CudaFunctions {
    compiled: CompiledBatches,
}

#[pymethods]
impl CudaFunctions {
    /// Computes a function on memory of the device: addresses, and their counts of numbers.
    #[pyo3(signature = (name, inputs, outputs, stream, columns))]
    fn _compute(
        &self,
        name: &str,
        inputs: RawPointers,
        outputs: RawPointers,
        stream: u64,
        columns: bool,
    ) -> PyResult<()> {
        let function = name.parse().map_err(exception)?;
        self.run(&function, (&inputs, &outputs), stream, order(columns)).map_err(device_exception)
    }

    /// Computes steps in places for states.
    #[pyo3(signature = (name, steps, states, held, outputs, stream, columns))]
    fn _rollout(
        &self,
        name: &str,
        steps: usize,
        states: Vec<RawPointers>,
        held: RawPointers,
        outputs: RawPointers,
        stream: u64,
        columns: bool,
    ) -> PyResult<()> {
        let function = name.parse().map_err(exception)?;
        let states: Vec<_> = states.iter().map(|place| pointers(place)).collect();
        let rollout = DeviceRollout {
            stream: caller_stream(stream),
            order: order(columns),
            function: &function,
            steps,
            states: &states,
            held: &pointers(&held),
            outputs: &pointers(&outputs),
        };
        match &self.compiled {
            CompiledBatches::F32(batches) => batches.rollout_on(&rollout),
            CompiledBatches::F64(batches) => batches.rollout_on(&rollout),
        }
        .map_err(device_exception)
    }
}

fn order(columns: bool) -> TableOrder {
    if columns { TableOrder::Columns } else { TableOrder::Rows }
}

impl CudaFunctions {
    /// Whether the functions are in float32.
    pub(super) fn is_single(&self) -> bool {
        matches!(self.compiled, CompiledBatches::F32(_))
    }

    /// Computes a function, with errors as texts.
    pub(super) fn compute(
        &self,
        name: &str,
        inputs: &[RawPointer],
        outputs: &[RawPointer],
        stream: u64,
    ) -> Result<(), String> {
        let function: Function = name.parse().map_err(|error: FunctionError| error.to_string())?;
        let done = self.run(&function, (inputs, outputs), stream, TableOrder::Rows);
        done.map_err(|error| error.to_string())
    }

    fn run(
        &self,
        function: &Function,
        (inputs, outputs): (&[RawPointer], &[RawPointer]),
        stream: u64,
        order: TableOrder,
    ) -> Result<(), DeviceError> {
        let (inputs, outputs, stream) = (pointers(inputs), pointers(outputs), caller_stream(stream));
        match &self.compiled {
            CompiledBatches::F32(batches) => batches.compute_on(stream, order, function, &inputs, &outputs),
            CompiledBatches::F64(batches) => batches.compute_on(stream, order, function, &inputs, &outputs),
        }
    }
}
