//! The run of a solver from Python: its start, its iterations, and its trajectory.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use robot_dynamics::control::optimal::{Fddp, FddpReport, IterationRecord, OptimalControlError};

use super::raised;
use crate::numbers::{array, numbers, object};
use crate::outcome;

/// The start of a solver: states and controls, controls alone, or nothing.
#[derive(FromPyObject)]
pub(super) struct Start(Option<Vec<Py<PyAny>>>, Option<Vec<Py<PyAny>>>);

impl Start {
    /// Sets the start. Controls alone are rolled out.
    pub(super) fn set(&self, py: Python<'_>, solver: &mut Fddp) -> PyResult<()> {
        let rows = |name: &str, rows: &[Py<PyAny>]| {
            let row = |row: &Py<PyAny>| numbers(py, name, row.bind(py)).map(|(_, row)| row);
            rows.iter().map(row).collect::<PyResult<Vec<_>>>()
        };
        let Some(controls) = &self.1 else { return Ok(()) };
        let controls = rows("controls", controls)?;
        match &self.0 {
            Some(states) => {
                let set = solver.set_trajectory(&rows("states", states)?, &controls);
                set.map_err(|error| raised(py, error))
            }
            None => solver.set_rollout(&controls).map_err(|error| raised(py, error)),
        }
    }
}

/// The fields of an iteration, in the order of the Python half's class.
pub(super) type IterationFields = (usize, f64, f64, f64, f64, f64, f64);

fn fields(record: &IterationRecord) -> IterationFields {
    let IterationRecord { iteration, cost, defect, gradient, predicted_decrease, .. } = *record;
    (iteration, cost, defect, gradient, predicted_decrease, record.step_length, record.regularization)
}

/// The time between two checks for an interrupt.
const PATIENCE: Duration = Duration::from_millis(50);

/// Calls Python's function after each iteration, and checks for interrupts.
pub(super) struct IterationCallback {
    function: Option<Py<PyAny>>,
    last: Instant,
    error: Option<PyErr>,
}

impl IterationCallback {
    pub(super) fn new(function: Option<Py<PyAny>>) -> Self {
        Self { function, last: Instant::now(), error: None }
    }

    pub(super) fn call(&mut self, record: &IterationRecord) -> ControlFlow<()> {
        if self.function.is_none() && self.last.elapsed() < PATIENCE {
            return ControlFlow::Continue(());
        }
        let called = Python::attach(|py| {
            py.check_signals()?;
            let Some(function) = &self.function else { return Ok(false) };
            function.bind(py).call1((fields(record),))?.is_truthy()
        });
        self.last = Instant::now();
        match called {
            Ok(false) => ControlFlow::Continue(()),
            Ok(true) => ControlFlow::Break(()),
            Err(error) => {
                self.error = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// The result, or the exception that Python raised.
    pub(super) fn finish<R>(self, py: Python<'_>, solved: Result<R, OptimalControlError>) -> PyResult<R> {
        match self.error {
            Some(error) => Err(error),
            None => solved.map_err(|error| raised(py, error)),
        }
    }
}

/// The trajectory, gains and iterations of a solver.
pub(super) fn bare_solution<'py>(
    py: Python<'py>,
    solver: &Fddp,
    log: &[IterationRecord],
) -> PyResult<Bound<'py, PyDict>> {
    let problem = solver.problem();
    let (nodes, space) = (problem.nodes(), problem.state_space());
    let (coordinates, n) = (space.coordinates(), space.tangent());
    let states: Vec<f64> = (0..=nodes).flat_map(|node| solver.state(node)).copied().collect();
    let (controls, gains) = (PyList::empty(py), PyList::empty(py));
    for node in 0..nodes {
        controls.append(array(py, solver.control(node))?)?;
        gains.append(outcome::filled(py, &[problem.controls(node), n], solver.gain(node))?)?;
    }
    let record = PyDict::new(py);
    record.set_item("states", outcome::filled(py, &[nodes + 1, coordinates], &states)?)?;
    record.set_item("controls", controls)?;
    record.set_item("gains", gains)?;
    record.set_item("log", log.iter().map(fields).collect::<Vec<_>>())?;
    Ok(record)
}

/// The same with the report of the solver.
pub(super) fn solution_of<'py>(
    py: Python<'py>,
    solver: &Fddp,
    report: &FddpReport,
    log: &[IterationRecord],
) -> PyResult<Bound<'py, PyDict>> {
    let record = bare_solution(py, solver, log)?;
    record.set_item("termination", object(py, report.termination.to_string())?)?;
    record.set_item("is_solved", report.is_solved())?;
    record.set_item("cost", report.cost)?;
    record.set_item("defect", report.defect)?;
    record.set_item("gradient", report.gradient)?;
    Ok(record)
}
