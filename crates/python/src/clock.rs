//! The time of a call without Python. `bench/peers/python_calls.py` compares it with the time of the same
//! call from Python.

use std::hint::black_box;
use std::time::Instant;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::model::Workspace;
use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};

use crate::numbers::{configuration, vector};
use crate::robot::Robot;

/// The least time of one call of a quantity from Rust, over rounds of a hundred calls [ns].
#[pyfunction]
pub(crate) fn _nanoseconds(
    py: Python<'_>,
    robot: &Bound<'_, Robot>,
    name: &str,
    state: [Bound<'_, PyAny>; 4],
    rounds: usize,
) -> PyResult<f64> {
    let robot = robot.get();
    let model = &robot.model;
    let quantity =
        Quantity::named(name).ok_or_else(|| PyValueError::new_err(format!("no quantity {name:?}")))?;
    let q = configuration(py, robot, &state[0])?;
    let (v, a) = (vector(py, robot, "v", &state[1])?, vector(py, robot, "a", &state[2])?);
    let tau = vector(py, robot, "tau", &state[3])?;
    let frames = &robot.frames[robot.frames.len() - 1..];
    let inputs = Inputs { q: &q, v: &v, a: &a, tau: &tau, frames };
    let (mut workspace, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
    let mut least = f64::INFINITY;
    for _ in 0..rounds {
        let begun = Instant::now();
        for _ in 0..100 {
            quantity.compute(model, &mut workspace, black_box(&inputs), black_box(&mut memory));
        }
        least = least.min(begun.elapsed().as_secs_f64() * 1e7);
    }
    Ok(least)
}
