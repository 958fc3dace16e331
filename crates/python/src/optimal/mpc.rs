//! Model predictive control from Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::optimal::{Mpc, MpcOptions};

use super::problem::{OptimalProblem, SolverOptions, common_controls, duration};
use super::raised;
use super::residuals::cost_of;
use super::solution::{Start, solution_of};
use super::space::Space;
use crate::errors::Class;
use crate::exclusive::Exclusive;
use crate::numbers::{array, object};

/// The native half of `robot_dynamics.optimal.Mpc`.
#[pyclass(subclass, module = "robot_dynamics._native")]
pub(crate) struct OptimalMpc {
    mpc: Exclusive<Mpc>,
    space: Space,
}

#[pymethods]
impl OptimalMpc {
    #[new]
    fn new(
        py: Python<'_>,
        problem: &Bound<'_, OptimalProblem>,
        options: SolverOptions,
        iterations: usize,
        time_budget: Option<f64>,
        rows: Start,
    ) -> PyResult<Self> {
        let problem = problem.borrow();
        let mut own = MpcOptions::default();
        own.solver = options.options(py)?;
        own.iterations = iterations;
        own.time_budget = time_budget.map(|seconds| duration(py, "time_budget", seconds)).transpose()?;
        let mut mpc = Mpc::new(problem.problem.lock(py).clone(), own).map_err(|error| raised(py, error))?;
        rows.set(py, mpc.fddp_mut())?;
        Ok(Self { mpc: Exclusive::new(mpc), space: problem.space.share(py) })
    }

    /// See `step`.
    fn _next_controls<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.space.state(py, "the state", state)?;
        let controls = py.detach(|| self.mpc.lock_detached().step(&state).map(<[f64]>::to_vec));
        array(py, &controls.map_err(|error| raised(py, error))?)
    }

    /// See `times`.
    fn _times(&self, py: Python<'_>) -> (usize, f64, f64, f64, usize) {
        let times = self.mpc.lock(py).times();
        let [median, percentile, longest] =
            [times.median, times.percentile_99_9, times.longest].map(|time| time.as_secs_f64());
        (times.periods, median, percentile, longest, times.over_budget)
    }

    /// See `plan`.
    fn _plan<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mpc = self.mpc.lock(py);
        let Some(report) = mpc.report() else {
            return Err(Class::Control.error(py, "there is no plan before the first step"));
        };
        let solver = mpc.fddp();
        let record = solution_of(py, solver, report, solver.log())?;
        record.set_item("violation", object(py, 0.0)?)?;
        Ok(record)
    }

    /// See `set_running_cost`.
    fn _set_running_cost(
        &self,
        py: Python<'_>,
        first: usize,
        end: usize,
        terms: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let controls = common_controls(py, self.mpc.lock(py).fddp().problem(), &(first..end))?;
        let cost = cost_of(py, &self.space, controls, &terms)?;
        let set = self.mpc.lock(py).fddp_mut().set_running_cost(first..end, &cost);
        set.map_err(|error| raised(py, error))
    }

    /// See `set_terminal_cost`.
    fn _set_terminal_cost(&self, py: Python<'_>, terms: Vec<Bound<'_, PyAny>>) -> PyResult<()> {
        let cost = cost_of(py, &self.space, 0, &terms)?;
        let set = self.mpc.lock(py).fddp_mut().set_terminal_cost(&cost);
        set.map_err(|error| raised(py, error))
    }
}
