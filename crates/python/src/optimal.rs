//! Optimal control: problems from the objects of `robot_dynamics.optimal`, their solutions, and MPC.

mod dynamics;
mod function;
pub(crate) mod mpc;
pub(crate) mod problem;
mod residuals;
mod sampling;
mod solution;
mod space;

use pyo3::prelude::*;
use robot_dynamics::control::optimal::OptimalControlError;
use robot_dynamics::simulation::{CallbackError, StepError};

use crate::errors::exception;

/// The exception of an error. An exception that Python raised in a callback is raised again.
#[cold]
fn raised(py: Python<'_>, error: impl Into<OptimalControlError>) -> PyErr {
    let error = error.into();
    if let OptimalControlError::Node { cause: StepError::Callback(callback), .. } = &error
        && let Some(own) = CallbackError::downcast_ref::<PyErr>(callback)
    {
        return own.clone_ref(py);
    }
    exception(error)
}
