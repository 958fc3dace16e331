//! Calls of these functions from programs that XLA compiles.

use std::sync::{PoisonError, RwLock};

use pyo3::prelude::*;

use super::cpu::CpuFunctions;
use super::cuda::CudaFunctions;
use crate::ffi::Kind;
use crate::ffi::xla::XlaCall;

/// Compiled functions that programs call, by their numbers. They are never dropped, because the end of the
/// last program is not reported.
struct Registry<T: 'static>(RwLock<Vec<&'static T>>);

static CPU: Registry<CpuFunctions> = Registry(RwLock::new(Vec::new()));
static CUDA: Registry<CudaFunctions> = Registry(RwLock::new(Vec::new()));

impl<T: Sync> Registry<T> {
    /// The number of these functions, which `keep` keeps in memory when they are called first.
    fn number(&self, functions: &T, keep: impl FnOnce() -> &'static T) -> u64 {
        let mut all = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let number = all.iter().position(|own| core::ptr::eq(*own, functions)).unwrap_or(all.len());
        if number == all.len() {
            all.push(keep());
        }
        number as u64
    }

    /// The functions of a call.
    fn of_call(&self, call: &XlaCall<'_>) -> Result<&'static T, String> {
        let number = usize::try_from(call.whole("functions")?).unwrap_or(usize::MAX);
        let all = self.0.read().unwrap_or_else(PoisonError::into_inner);
        all.get(number).copied().ok_or_else(|| {
            "this program was compiled for functions that are not loaded in this process".to_owned()
        })
    }
}

#[pymethods]
impl CpuFunctions {
    /// The number by which programs of XLA call these functions. They stay in memory from now on.
    fn _xla_handle(slf: &Bound<'_, Self>) -> u64 {
        CPU.number(slf.get(), || Box::leak(Box::new(slf.clone().unbind())).get())
    }
}

#[pymethods]
impl CudaFunctions {
    /// The number by which programs of XLA call these functions. They stay in memory from now on.
    fn _xla_handle(slf: &Bound<'_, Self>) -> u64 {
        CUDA.number(slf.get(), || Box::leak(Box::new(slf.clone().unbind())).get())
    }
}

/// A function on this processor.
pub(crate) fn cpu_call(mut call: XlaCall<'_>) -> Result<(), String> {
    let functions = CPU.of_call(&call)?;
    let name = call.text("name")?;
    let first = call.arguments().first().ok_or("the call has no arrays")?;
    if first.kind == Kind::F32 {
        let (inputs, outputs) = call.take::<f32>().ok_or("all arrays must be float32")?;
        functions.compute_f32(name, &inputs, outputs)
    } else {
        let (inputs, outputs) = call.take::<f64>().ok_or("all arrays must be float64")?;
        functions.compute_f64(name, &inputs, outputs)
    }
}

/// A function on a card, on the stream of the program.
pub(crate) fn cuda_call(call: XlaCall<'_>) -> Result<(), String> {
    let functions = CUDA.of_call(&call)?;
    let all = call.arguments().iter().chain(call.results());
    let kind = if functions.is_single() { Kind::F32 } else { Kind::F64 };
    if all.into_iter().any(|buffer| buffer.kind != kind) {
        return Err("an array has another type than the compiled functions".into());
    }
    let (inputs, outputs) = call.device_memory();
    functions.compute(call.text("name")?, &inputs, &outputs, call.device_stream()?)
}
