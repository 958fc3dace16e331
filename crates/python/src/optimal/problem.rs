//! An optimal control problem as Python builds it.

use std::ops::Range;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::optimal::{
    AugmentedLagrangian, AugmentedLagrangianOptions, ControlBounds, Fddp, FddpOptions, Problem,
};

use super::dynamics::dynamics_of;
use super::raised;
use super::residuals::{cost_of, entries_of, residual_of};
use super::solution::{IterationCallback, Start, bare_solution, solution_of};
use super::space::Space;
use crate::errors::Class;
use crate::exclusive::Exclusive;
use crate::numbers::object;

/// The native half of `robot_dynamics.optimal.Problem`.
#[pyclass(subclass, module = "robot_dynamics._native")]
pub(crate) struct OptimalProblem {
    /// Its parts are not for several threads at once.
    pub(super) problem: Exclusive<Problem>,
    pub(super) space: Space,
    has_constraints: bool,
}

/// The options of a solver, by the names of the Python half.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(super) struct SolverOptions {
    max_iterations: usize,
    gradient_tolerance: f64,
    defect_tolerance: f64,
    decrease_tolerance: f64,
    threads: usize,
    /// \[s\].
    time_limit: Option<f64>,
}

impl SolverOptions {
    pub(super) fn options(self, py: Python<'_>) -> PyResult<FddpOptions> {
        let mut options = FddpOptions::default();
        options.max_iterations = self.max_iterations;
        options.gradient_tolerance = self.gradient_tolerance;
        options.defect_tolerance = self.defect_tolerance;
        options.decrease_tolerance = self.decrease_tolerance;
        options.threads = self.threads;
        options.time_limit =
            self.time_limit.map(|seconds| duration(py, "time_limit", seconds)).transpose()?;
        Ok(options)
    }
}

/// A time in seconds.
pub(super) fn duration(py: Python<'_>, name: &str, seconds: f64) -> PyResult<std::time::Duration> {
    std::time::Duration::try_from_secs_f64(seconds).map_err(|_| {
        Class::Control.error(py, format!("{name} = {seconds} must be a time in seconds, 0 or above"))
    })
}

#[pymethods]
impl OptimalProblem {
    #[new]
    fn new(
        py: Python<'_>,
        dynamics: &Bound<'_, PyAny>,
        initial_state: &Bound<'_, PyAny>,
        nodes: usize,
    ) -> PyResult<Self> {
        let (dynamics, space) = dynamics_of(py, dynamics, None)?;
        let state = space.state(py, "the initial state", initial_state)?;
        let problem = Problem::new(dynamics, &state, nodes).map_err(|error| raised(py, error))?;
        Ok(Self { problem: Exclusive::new(problem), space, has_constraints: false })
    }

    /// Number of nodes N; a trajectory has N + 1 states.
    #[getter]
    fn nodes(&self, py: Python<'_>) -> usize {
        self.problem.lock(py).nodes()
    }

    /// Number of controls of each node (N,).
    #[getter]
    fn controls(&self, py: Python<'_>) -> Vec<usize> {
        let problem = self.problem.lock(py);
        (0..problem.nodes()).map(|node| problem.controls(node)).collect()
    }

    /// (nq, nv), or (0, n) for plain numbers.
    fn _sizes(&self) -> (usize, usize) {
        match self.space.states.model() {
            Some(model) => (model.nq(), model.nv()),
            None => (0, self.space.states.coordinates()),
        }
    }

    /// See `set_initial_state`.
    fn _set_initial_state(&self, py: Python<'_>, initial_state: &Bound<'_, PyAny>) -> PyResult<()> {
        let state = self.space.state(py, "the initial state", initial_state)?;
        self.problem.lock(py).set_initial_state(&state).map_err(|error| raised(py, error))
    }

    /// See `set_dynamics`.
    fn _set_dynamics(
        &self,
        py: Python<'_>,
        first: usize,
        end: usize,
        dynamics: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (dynamics, _) = dynamics_of(py, dynamics, Some(&self.space))?;
        self.problem.lock(py).set_dynamics(first..end, dynamics).map_err(|error| raised(py, error))
    }

    /// See `set_running_cost`.
    fn _set_running_cost(
        &self,
        py: Python<'_>,
        first: usize,
        end: usize,
        terms: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let controls = self.controls_in(py, &(first..end))?;
        let cost = cost_of(py, &self.space, controls, &terms)?;
        self.problem.lock(py).set_running_cost(first..end, cost).map_err(|error| raised(py, error))
    }

    /// See `set_terminal_cost`.
    fn _set_terminal_cost(&self, py: Python<'_>, terms: Vec<Bound<'_, PyAny>>) -> PyResult<()> {
        let cost = cost_of(py, &self.space, 0, &terms)?;
        self.problem.lock(py).set_terminal_cost(cost).map_err(|error| raised(py, error))
    }

    /// See `set_control_bounds`.
    fn _set_control_bounds(
        &self,
        py: Python<'_>,
        first: usize,
        end: usize,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let controls = self.controls_in(py, &(first..end))?;
        let lower = entries_of(py, "lower", lower, controls, f64::NEG_INFINITY)?;
        let upper = entries_of(py, "upper", upper, controls, f64::INFINITY)?;
        let bounds = ControlBounds::new(&lower, &upper).map_err(|error| raised(py, error))?;
        self.problem.lock(py).set_control_bounds(first..end, bounds).map_err(|error| raised(py, error))
    }

    /// See `set_effort_limits`.
    fn _set_effort_limits(&self, py: Python<'_>, first: usize, end: usize) -> PyResult<()> {
        let (_, model) = self.space.robot(py, "set_effort_limits")?;
        let controls = self.controls_in(py, &(first..end))?;
        let bounds = ControlBounds::effort_limits(model);
        let motors = bounds.lower().len();
        if controls != motors {
            let message = format!(
                "the nodes have {controls} controls, and robot `{}` has {motors} motors; set the bounds by \
                 set_control_bounds, or take actuation=\"motors\"",
                model.name()
            );
            return Err(Class::Control.error(py, message));
        }
        self.problem.lock(py).set_control_bounds(first..end, bounds).map_err(|error| raised(py, error))
    }

    /// See `add_constraint`.
    fn _add_constraint(
        &mut self,
        py: Python<'_>,
        first: usize,
        end: usize,
        residual: &Bound<'_, PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let controls = self.controls_in(py, &(first..end))?;
        let residual = residual_of(py, &self.space, controls, residual)?;
        let lower = entries_of(py, "lower", lower, residual.dimension(), f64::NEG_INFINITY)?;
        let upper = entries_of(py, "upper", upper, residual.dimension(), f64::INFINITY)?;
        let added = self.problem.lock(py).add_constraint(first..end, residual, &lower, &upper);
        added.map_err(|error| raised(py, error))?;
        self.has_constraints = true;
        Ok(())
    }

    /// See `add_terminal_constraint`.
    fn _add_terminal_constraint(
        &mut self,
        py: Python<'_>,
        residual: &Bound<'_, PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let residual = residual_of(py, &self.space, 0, residual)?;
        let lower = entries_of(py, "lower", lower, residual.dimension(), f64::NEG_INFINITY)?;
        let upper = entries_of(py, "upper", upper, residual.dimension(), f64::INFINITY)?;
        let added = self.problem.lock(py).add_terminal_constraint(residual, &lower, &upper);
        added.map_err(|error| raised(py, error))?;
        self.has_constraints = true;
        Ok(())
    }

    /// See `solve`.
    fn _solve<'py>(
        &self,
        py: Python<'py>,
        options: SolverOptions,
        constraint_tolerance: f64,
        rows: Start,
        callback: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let inner = options.options(py)?;
        let mut callback = IterationCallback::new(callback);
        let problem = self.problem.lock(py).clone();
        if !self.has_constraints {
            let mut solver = Fddp::new(problem, inner).map_err(|error| raised(py, error))?;
            rows.set(py, &mut solver)?;
            let solved = py.detach(|| solver.solve_with(|record| callback.call(record)));
            let report = callback.finish(py, solved)?;
            let record = solution_of(py, &solver, &report, solver.log())?;
            record.set_item("violation", object(py, 0.0)?)?;
            return Ok(record);
        }
        let mut options = AugmentedLagrangianOptions::default();
        (options.inner, options.constraint_tolerance) = (inner, constraint_tolerance);
        let mut solver = AugmentedLagrangian::new(problem, options).map_err(|error| raised(py, error))?;
        rows.set(py, solver.fddp_mut())?;
        let mut log = Vec::new();
        let solved = py.detach(|| {
            solver.solve_with(|record| {
                log.push(*record);
                callback.call(record)
            })
        });
        let report = callback.finish(py, solved)?;
        let record = bare_solution(py, solver.fddp(), &log)?;
        record.set_item("termination", report.termination.to_string())?;
        record.set_item("is_solved", report.is_solved())?;
        record.set_item("cost", report.cost)?;
        record.set_item("defect", report.defect)?;
        record.set_item("gradient", report.gradient)?;
        record.set_item("violation", report.violation)?;
        Ok(record)
    }
}

impl OptimalProblem {
    /// The number of controls of these nodes; an error if it differs between them.
    fn controls_in(&self, py: Python<'_>, nodes: &Range<usize>) -> PyResult<usize> {
        common_controls(py, &self.problem.lock(py), nodes)
    }
}

/// The number of controls of these nodes; an error if it differs between them.
pub(super) fn common_controls(py: Python<'_>, problem: &Problem, nodes: &Range<usize>) -> PyResult<usize> {
    let count = problem.nodes();
    if nodes.start >= nodes.end || nodes.end > count {
        let message = format!("the nodes {}..{} must be a range within 0..{count}", nodes.start, nodes.end);
        return Err(Class::Control.error(py, message));
    }
    let controls = problem.controls(nodes.start);
    if nodes.clone().any(|node| problem.controls(node) != controls) {
        let message = "the nodes have different numbers of controls; set those of each number alone";
        return Err(Class::Control.error(py, message));
    }
    Ok(controls)
}
