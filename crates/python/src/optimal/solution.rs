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
        let Some(controls) = self.controls(py)? else { return Ok(()) };
        match &self.0 {
            Some(states) => {
                let set = solver.set_trajectory(&rows(py, "states", states)?, &controls);
                set.map_err(|error| raised(py, error))
            }
            None => solver.set_rollout(&controls).map_err(|error| raised(py, error)),
        }
    }

    /// The controls, if they are given.
    pub(super) fn controls(&self, py: Python<'_>) -> PyResult<Option<Vec<Vec<f64>>>> {
        self.1.as_ref().map(|controls| rows(py, "controls", controls)).transpose()
    }
}

fn rows(py: Python<'_>, name: &str, rows: &[Py<PyAny>]) -> PyResult<Vec<Vec<f64>>> {
    rows.iter().map(|row| numbers(py, name, row.bind(py)).map(|(_, row)| row)).collect()
}

/// The fields of an iteration, in the order of the Python half's class.
pub(super) type IterationFields = (usize, f64, f64, f64, f64, f64, f64);

fn fields(record: &IterationRecord) -> IterationFields {
    let IterationRecord { iteration, cost, defect, gradient, predicted_decrease, .. } = *record;
    (iteration, cost, defect, gradient, predicted_decrease, record.step_length, record.regularization)
}

/// The time between two checks for an interrupt.
const PATIENCE: Duration = Duration::from_millis(50);

/// Checks for interrupts, and keeps the exception that ended the work.
pub(super) struct InterruptCheck {
    last: Instant,
    error: Option<PyErr>,
}

impl Default for InterruptCheck {
    fn default() -> Self {
        Self { last: Instant::now(), error: None }
    }
}

impl InterruptCheck {
    /// Whether the last check was some time ago.
    pub(super) fn is_due(&self) -> bool {
        self.last.elapsed() >= PATIENCE
    }

    /// Ends the work if Python has a signal to handle.
    pub(super) fn check(&mut self) -> ControlFlow<()> {
        self.run(|_| Ok(false))
    }

    /// The same with a function of Python, which may end the work or raise an exception.
    fn run(&mut self, function: impl FnOnce(Python<'_>) -> PyResult<bool>) -> ControlFlow<()> {
        let ends = Python::attach(|py| py.check_signals().and_then(|()| function(py)));
        self.last = Instant::now();
        match ends {
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

/// Calls Python's function after each iteration, and checks for interrupts.
pub(super) struct IterationCallback {
    function: Option<Py<PyAny>>,
    check: InterruptCheck,
}

impl IterationCallback {
    pub(super) fn new(function: Option<Py<PyAny>>) -> Self {
        Self { function, check: InterruptCheck::default() }
    }

    pub(super) fn call(&mut self, record: &IterationRecord) -> ControlFlow<()> {
        match &self.function {
            Some(function) => self.check.run(|py| function.bind(py).call1((fields(record),))?.is_truthy()),
            None if self.check.is_due() => self.check.check(),
            None => ControlFlow::Continue(()),
        }
    }

    /// The result, or the exception that Python raised.
    pub(super) fn finish<R>(self, py: Python<'_>, solved: Result<R, OptimalControlError>) -> PyResult<R> {
        self.check.finish(py, solved)
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
