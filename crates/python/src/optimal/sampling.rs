//! Optimal control by sampling, from Python.

use std::ops::ControlFlow;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use robot_dynamics::control::optimal::{Fddp, FddpOptions, Sampling, SamplingLaw, SamplingOptions};

use super::problem::{OptimalProblem, duration};
use super::raised;
use super::solution::{InterruptCheck, Start};
use crate::numbers::{array, numbers};
use crate::outcome;

/// The options of a sampling, by the names of the Python half.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(super) struct SamplingFields {
    law: String,
    deviation: Py<PyAny>,
    temperature: f64,
    elites: usize,
    least_deviation: f64,
    samples: usize,
    iterations: usize,
    correlation: f64,
    seed: u64,
    threads: usize,
    /// \[s\].
    time_limit: Option<f64>,
}

impl SamplingFields {
    fn options(self, py: Python<'_>) -> PyResult<SamplingOptions> {
        let law = match self.law.as_str() {
            "mppi" => SamplingLaw::Mppi { temperature: self.temperature },
            "cross_entropy" => {
                SamplingLaw::CrossEntropy { elites: self.elites, least_deviation: self.least_deviation }
            }
            other => {
                let message = format!("law = {other:?} must be \"mppi\" or \"cross_entropy\"");
                return Err(PyValueError::new_err(message));
            }
        };
        let deviation = self.deviation.bind(py);
        let deviation = match deviation.extract::<f64>() {
            Ok(one) => vec![one],
            Err(_) => numbers(py, "deviation", deviation)?.1,
        };
        let mut options = SamplingOptions::new(law, &deviation);
        (options.samples, options.iterations) = (self.samples, self.iterations);
        (options.correlation, options.seed, options.threads) = (self.correlation, self.seed, self.threads);
        options.time_limit =
            self.time_limit.map(|seconds| duration(py, "time_limit", seconds)).transpose()?;
        Ok(options)
    }
}

#[pymethods]
impl OptimalProblem {
    /// See `sample`.
    fn _sample<'py>(
        &self,
        py: Python<'py>,
        options: SamplingFields,
        rows: Start,
    ) -> PyResult<Bound<'py, PyDict>> {
        let problem = self.problem.lock(py).clone();
        let mut sampling =
            Sampling::new(problem.clone(), options.options(py)?).map_err(|error| raised(py, error))?;
        if let Some(controls) = rows.controls(py)? {
            sampling.set_controls(&controls).map_err(|error| raised(py, error))?;
        }
        let mut check = InterruptCheck::default();
        let solved = py.detach(|| {
            sampling.solve_with(|_| if check.is_due() { check.check() } else { ControlFlow::Continue(()) })
        });
        let report = check.finish(py, solved)?;
        // The states of the controls.
        let mut rollout = Fddp::new(problem, FddpOptions::default()).map_err(|error| raised(py, error))?;
        let nodes = sampling.problem().nodes();
        let controls: Vec<Vec<f64>> = (0..nodes).map(|node| sampling.control(node).to_vec()).collect();
        rollout.set_rollout(&controls).map_err(|error| raised(py, error))?;
        let states: Vec<f64> = (0..=nodes).flat_map(|node| rollout.state(node)).copied().collect();
        let coordinates = self.space.states.coordinates();
        let columns = PyList::empty(py);
        for row in &controls {
            columns.append(array(py, row)?)?;
        }
        let log: Vec<_> = sampling
            .log()
            .iter()
            .map(|one| (one.iteration, one.mean_cost, one.best_cost, one.effective_samples, one.failed))
            .collect();
        let record = PyDict::new(py);
        record.set_item("states", outcome::filled(py, &[nodes + 1, coordinates], &states)?)?;
        record.set_item("controls", columns)?;
        record.set_item("cost", report.cost)?;
        record.set_item("initial_cost", report.initial_cost)?;
        record.set_item("failed", report.failed)?;
        record.set_item("termination", report.termination.to_string())?;
        record.set_item("log", log)?;
        Ok(record)
    }
}
