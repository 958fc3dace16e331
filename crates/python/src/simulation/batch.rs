//! Many simulations of one robot, as Python steps them.

use std::sync::atomic::AtomicBool;

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::batch::SimulationBatch as Stepped;
use robot_dynamics::check_configuration;
use robot_dynamics::simulator::Simulation as Single;

use super::setup::Setup;
use super::stepping::Simulation;
use crate::errors::Class;
use crate::interrupts::{FEW_STEPS, interruptible};
use crate::numbers::{numbers, shaped};
use crate::operand::shown;
use crate::outcome;
use crate::robot::Robot;
use crate::threads;

/// The native half of `robot_dynamics.SimulationBatch`.
#[pyclass(subclass, module = "robot_dynamics._native")]
pub(crate) struct SimulationBatch {
    robot: Py<Robot>,
    stepped: Stepped,
    threads: usize,
}

#[pymethods]
impl SimulationBatch {
    #[new]
    #[pyo3(signature = (robot, count, threads, **options))]
    fn new(
        py: Python<'_>,
        robot: Py<Robot>,
        count: usize,
        threads: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let simulation = Setup::of(options)?.build(py, robot.get())?;
        let threads = threads::count_of(threads)?.unwrap_or_else(threads::default_count);
        let pool = threads::pool(threads)?;
        let stepped = py.detach(|| Stepped::new(&simulation, count, &pool));
        Ok(Self { robot, stepped, threads })
    }

    fn __len__(&self) -> usize {
        self.stepped.simulations().len()
    }

    /// The step [s].
    #[getter]
    fn step_size(&self) -> f64 {
        self.stepped.simulations().first().map_or(f64::NAN, Single::step_size)
    }

    /// The configurations (count, nq), a copy.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robot.get().model.nq(), Single::q)
    }

    /// The velocities (count, nv), a copy.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robot.get().model.nv(), Single::v)
    }

    /// The times (count,) [s].
    #[getter]
    fn times(&self) -> Vec<f64> {
        self.stepped.simulations().iter().map(Single::time).collect()
    }

    /// The torques of the next steps (count, nv), held until they are set again; (nv,) sets those of all [N·m or N].
    #[setter]
    fn set_torques(&mut self, py: Python<'_>, torques: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = self.rows(py, "torques", torques, self.robot.get().model.nv())?;
        for (simulation, row) in self.stepped.simulations_mut().iter_mut().zip(rows) {
            simulation.set_torques(&row);
        }
        Ok(())
    }

    #[getter]
    fn torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robot.get().model.nv(), Single::torques)
    }

    /// The controls of the actuators that act (count, controls), held until they are set again; (controls,) sets those of all.
    #[setter]
    fn set_controls(&mut self, py: Python<'_>, controls: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = self.rows(py, "controls", controls, self.control_count())?;
        for (simulation, row) in self.stepped.simulations_mut().iter_mut().zip(rows) {
            simulation.set_controls(&row);
        }
        Ok(())
    }

    #[getter]
    fn controls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.control_count(), Single::controls)
    }

    /// See `reset`.
    fn _reset(
        &mut self,
        py: Python<'_>,
        q: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        which: Option<Vec<usize>>,
    ) -> PyResult<()> {
        let model = &self.robot.get().model;
        let count = self.stepped.simulations().len();
        let which = which.unwrap_or_else(|| (0..count).collect());
        if let Some(number) = which.iter().find(|number| **number >= count) {
            return Err(PyIndexError::new_err(format!(
                "there is no simulation {number}: the batch has {count}"
            )));
        }
        let rows = |name: &str, object: Option<&Bound<'_, PyAny>>, default: Vec<f64>| match object {
            Some(object) => rows_of(py, name, object, (which.len(), default.len())),
            None => Ok(vec![default; which.len()]),
        };
        let q = rows("q", q, model.initial_configuration())?;
        let v = rows("v", v, vec![0.0; model.nv()])?;
        for (row, q) in q.iter().enumerate() {
            check_configuration(model, q)
                .map_err(|error| PyValueError::new_err(format!("row {row} of q: {error}")))?;
        }
        for ((number, q), v) in which.iter().zip(&q).zip(&v) {
            self.stepped.simulations_mut()[*number]
                .reset(q, v)
                .map_err(|error| Class::Simulation.error(py, format!("simulation {number}: {error}")))?;
        }
        Ok(())
    }

    /// Takes so many steps of each simulation, on all threads. A simulation that cannot go on is an error, which names the first one; it stays where its
    /// last good step ended, and the others take all steps.
    #[pyo3(signature = (count=1))]
    fn step(&mut self, py: Python<'_>, count: usize) -> PyResult<()> {
        // Threads of a process that was forked are its own.
        self.stepped.set_threads(&threads::pool(self.threads)?);
        let all = self.stepped.simulations().len();
        let stepped = &mut self.stepped;
        let work = all * count;
        let failed = interruptible(py, work <= FEW_STEPS / 100, |cancelled: &AtomicBool| {
            stepped.step(count, cancelled)
        })?;
        let Some((first, error)) = failed.first() else { return Ok(()) };
        let verb = if failed.len() == 1 { "fails" } else { "fail" };
        let said =
            format!("{} of {all} simulations {verb}, the first is simulation {first}: {error}", failed.len());
        Err(Class::Simulation.error(py, said))
    }

    /// A copy of one simulation, with its state and inputs.
    fn _copy(&self, py: Python<'_>, number: usize) -> PyResult<Simulation> {
        let simulations = self.stepped.simulations();
        let simulation = simulations.get(number).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "there is no simulation {number}: the batch has {}",
                simulations.len()
            ))
        })?;
        Ok(Simulation::of(self.robot.clone_ref(py), simulation.clone()))
    }
}

impl SimulationBatch {
    fn control_count(&self) -> usize {
        self.stepped.simulations().first().map_or(0, |simulation| simulation.controls().len())
    }

    /// A row of numbers of each simulation.
    fn table<'py>(
        &self,
        py: Python<'py>,
        width: usize,
        row: impl Fn(&Single) -> &[f64],
    ) -> PyResult<Bound<'py, PyAny>> {
        let simulations = self.stepped.simulations();
        let mut numbers = Vec::with_capacity(simulations.len() * width);
        for simulation in simulations {
            numbers.extend_from_slice(row(simulation));
        }
        outcome::filled(py, &[simulations.len(), width], &numbers)
    }

    fn rows(
        &self,
        py: Python<'_>,
        name: &str,
        object: &Bound<'_, PyAny>,
        width: usize,
    ) -> PyResult<Vec<Vec<f64>>> {
        rows_of(py, name, object, (self.stepped.simulations().len(), width))
    }
}

/// So many rows, or one for all.
fn rows_of(
    py: Python<'_>,
    name: &str,
    object: &Bound<'_, PyAny>,
    (count, width): (usize, usize),
) -> PyResult<Vec<Vec<f64>>> {
    let (shape, x) = numbers(py, name, object)?;
    if shape == [width] {
        return Ok(vec![x; count]);
    }
    let (_, x) = shaped(py, name, object, &[count, width]).map_err(|_| {
        let asked = format!("{} or ({width},)", shown(&[count, width]));
        Class::Shape.error(py, format!("{name} has shape {}, it must have {asked}", shown(&shape)))
    })?;
    Ok(if width == 0 { vec![Vec::new(); count] } else { x.chunks(width).map(<[f64]>::to_vec).collect() })
}
