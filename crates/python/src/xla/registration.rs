//! The handlers as Python registers them.

use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

use crate::ffi::handlers::HANDLERS;
use crate::ffi::xla::capsule;

/// The functions that programs of XLA call, by the names of their targets.
#[pyfunction]
pub(crate) fn _xla_handlers(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let handlers = PyDict::new(py);
    for (name, handler) in HANDLERS {
        let capsule: Bound<'_, PyCapsule> = capsule(py, *handler)?;
        handlers.set_item(name, capsule)?;
    }
    Ok(handlers)
}
