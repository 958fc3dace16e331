//! Functions of generated code on arrays of a device: CUDA's, or this processor.

mod cpu;
mod cuda;
mod signature;
mod xla;

pub(crate) use cpu::CpuFunctions;
pub(crate) use cuda::{CudaDevice, CudaFunctions};
pub(crate) use signature::{_contact_links, _device_signature};
pub(crate) use xla::{cpu_call, cuda_call};

use pyo3::prelude::*;
use robot_dynamics_generate::{Function, FunctionError, GenerateError};
use robot_dynamics_gpu::DeviceError;

use crate::errors::{exception, exception_of};

/// The functions with these names.
fn functions_of(names: &[String]) -> PyResult<Vec<Function>> {
    let parse =
        |name: &String| name.parse().map_err(|error: FunctionError| exception_of::<GenerateError>(error));
    names.iter().map(parse).collect()
}

/// The exception of a device; code that cannot be generated is an error of its own.
fn device_exception(error: DeviceError) -> PyErr {
    match error {
        DeviceError::Generate(error) => exception(error),
        error => exception(error),
    }
}
