//! Many simulations of one robot, as Python steps them.

use std::sync::atomic::AtomicBool;

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use robot_dynamics::batch::SimulationBatch as Stepped;
use robot_dynamics::simulation::{RunError, Simulation as Single};

use super::batch_variants::check_alike;
use super::options::{GroundFields, Setup};
use super::stepping::Simulation;
use crate::errors::Class;
use crate::interrupts::{FEW_STEPS, interruptible};
use crate::numbers::numbers;
use crate::operand::shown;
use crate::robot::Robot;
use crate::{outcome, threads};

/// The native half of `robot_dynamics.SimulationBatch`.
#[pyclass(subclass, module = "robot_dynamics._native")]
pub(crate) struct SimulationBatch {
    /// The robot of simulation k is that of index k modulo their number.
    pub(super) robots: Vec<Py<Robot>>,
    pub(super) stepped: Stepped,
    threads: usize,
}

#[pymethods]
impl SimulationBatch {
    #[new]
    #[pyo3(signature = (robot, count, threads, variants, **options))]
    fn new(
        py: Python<'_>,
        robot: Py<Robot>,
        count: usize,
        threads: Option<&Bound<'_, PyAny>>,
        variants: Vec<(Py<Robot>, Option<GroundFields>)>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut kinds = Vec::with_capacity(variants.len().max(1));
        let mut robots = Vec::with_capacity(variants.len().max(1));
        for (own, ground) in variants {
            let mut setup = Setup::of(options)?;
            setup.ground = ground;
            kinds.push(setup.build(py, own.get())?);
            robots.push(own);
        }
        if kinds.is_empty() {
            kinds.push(Setup::of(options)?.build(py, robot.get())?);
            robots.push(robot);
        }
        check_alike(py, &kinds)?;
        let threads = threads::count_of(threads)?.unwrap_or_else(threads::default_count);
        let pool = threads::pool(threads)?;
        let stepped =
            py.detach(|| Stepped::of((0..count).map(|k| kinds[k % kinds.len()].clone()).collect(), &pool));
        Ok(Self { robots, stepped, threads })
    }

    fn __len__(&self) -> usize {
        self.stepped.simulations().len()
    }

    /// The robot, of the first simulation if they differ.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robots[0].clone_ref(py)
    }

    /// Length of a step [s].
    #[getter]
    fn dt(&self) -> f64 {
        self.stepped.simulations().first().map_or(f64::NAN, Single::dt)
    }

    /// The names of the actuators that act, in the order of `controls`.
    #[getter]
    fn control_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let first = self.stepped.simulations().first();
        PyTuple::new(py, first.map_or(Vec::new(), |first| first.control_names().collect()))
    }

    /// The configurations (count, nq), a copy.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robots[0].get().model.nq(), Single::q)
    }

    /// The velocities (count, nv), a copy.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robots[0].get().model.nv(), Single::v)
    }

    /// The times (count,) [s].
    #[getter]
    fn times(&self) -> Vec<f64> {
        self.stepped.simulations().iter().map(Single::time).collect()
    }

    /// The torques of the next steps (count, nv), held until they are set again; (nv,) sets those of all [N·m
    /// or N].
    #[setter]
    fn set_torques(&mut self, py: Python<'_>, torques: &Bound<'_, PyAny>) -> PyResult<()> {
        let width = self.robots[0].get().model.nv();
        self.set_each(py, "torques", torques, width, Single::set_torques)
    }

    #[getter]
    fn torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robots[0].get().model.nv(), Single::torques)
    }

    /// The controls of the actuators that act (count, controls), held until they are set again; (controls,)
    /// sets those of all.
    #[setter]
    fn set_controls(&mut self, py: Python<'_>, controls: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_each(py, "controls", controls, self.control_count(), Single::set_controls)
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
        let places = self.places(py, (q, v), which)?;
        let stepped = &mut self.stepped;
        let failed = py.detach(|| stepped.reset_where(&places.which, &places.q, &places.v));
        self.told(py, "cannot start there", &failed)
    }

    /// See `set_state`.
    fn _set_state(
        &mut self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        v: &Bound<'_, PyAny>,
        which: Option<Vec<usize>>,
    ) -> PyResult<()> {
        let places = self.places(py, (Some(q), Some(v)), which)?;
        let stepped = &mut self.stepped;
        let failed = py.detach(|| stepped.set_states_where(&places.which, &places.q, &places.v));
        self.told(py, "cannot go on from there", &failed)
    }

    /// See `step`.
    fn _step(&mut self, py: Python<'_>, count: usize, which: Option<Vec<usize>>) -> PyResult<()> {
        let which = which.map(|which| self.mask(&which)).transpose()?;
        // A process that was forked has its own threads.
        self.stepped.set_threads(&threads::pool(self.threads)?);
        let work = self.stepped.simulations().len() * count;
        let stepped = &mut self.stepped;
        let failed = interruptible(py, work <= FEW_STEPS / 100, |cancelled: &AtomicBool| match &which {
            Some(which) => stepped.step_where(which, count, cancelled),
            None => stepped.step(count, cancelled),
        })?;
        self.told(py, "cannot go on", &failed)
    }

    /// A copy of one simulation, with its state and inputs.
    fn _copy(&self, py: Python<'_>, number: usize) -> PyResult<Simulation> {
        let simulation = self.stepped.simulations().get(number).ok_or_else(|| self.no_such(number))?;
        let robot = &self.robots[number % self.robots.len()];
        Ok(Simulation::of(robot.clone_ref(py), simulation.clone()))
    }
}

/// A row of q and v for each simulation, and which of them are meant.
struct Places {
    which: Vec<bool>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl SimulationBatch {
    /// The number of simulations, at least one.
    pub(super) fn count(&self) -> PyResult<usize> {
        match self.stepped.simulations().len() {
            0 => Err(self.no_such(0)),
            count => Ok(count),
        }
    }

    pub(super) fn control_count(&self) -> usize {
        self.stepped.simulations().first().map_or(0, |simulation| simulation.controls().len())
    }

    pub(super) fn activation_count(&self) -> usize {
        self.stepped.simulations().first().map_or(0, |simulation| simulation.activations().len())
    }

    #[cold]
    fn no_such(&self, number: usize) -> PyErr {
        let count = self.stepped.simulations().len();
        PyIndexError::new_err(format!("there is no simulation {number}: the batch has {count}"))
    }

    /// A row of numbers of each simulation.
    pub(super) fn table<'py>(
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

    /// Sets a row of numbers of each simulation.
    pub(super) fn set_each(
        &mut self,
        py: Python<'_>,
        name: &str,
        object: &Bound<'_, PyAny>,
        width: usize,
        set: impl Fn(&mut Single, &[f64]),
    ) -> PyResult<()> {
        let rows = rows_of(py, name, object, (self.stepped.simulations().len(), width))?;
        for (number, simulation) in self.stepped.simulations_mut().iter_mut().enumerate() {
            set(simulation, &rows[number * width..(number + 1) * width]);
        }
        Ok(())
    }

    fn mask(&self, numbers: &[usize]) -> PyResult<Vec<bool>> {
        let mut mask = vec![false; self.stepped.simulations().len()];
        for &number in numbers {
            *mask.get_mut(number).ok_or_else(|| self.no_such(number))? = true;
        }
        Ok(mask)
    }

    /// The states that simulations are set to: a row for each of the numbers, one row for all, or the file's
    /// configuration at rest.
    fn places(
        &self,
        py: Python<'_>,
        (q, v): (Option<&Bound<'_, PyAny>>, Option<&Bound<'_, PyAny>>),
        numbers: Option<Vec<usize>>,
    ) -> PyResult<Places> {
        let model = &self.robots[0].get().model;
        let all = self.stepped.simulations().len();
        let numbers = numbers.unwrap_or_else(|| (0..all).collect());
        let which = self.mask(&numbers)?;
        let table = |name: &str, object: Option<&Bound<'_, PyAny>>, default: &[f64]| {
            let width = default.len();
            let rows = match object {
                Some(object) => rows_of(py, name, object, (numbers.len(), width))?,
                None => default.repeat(numbers.len()),
            };
            let mut table = vec![0.0; all * width];
            for (row, &number) in numbers.iter().enumerate() {
                table[number * width..(number + 1) * width]
                    .copy_from_slice(&rows[row * width..(row + 1) * width]);
            }
            PyResult::Ok(table)
        };
        let (q, v) = (table("q", q, &model.initial_configuration())?, table("v", v, &vec![0.0; model.nv()])?);
        Ok(Places { which, q, v })
    }

    /// The error that names the simulations that failed.
    fn told(&self, py: Python<'_>, verb: &str, failed: &[(usize, RunError)]) -> PyResult<()> {
        let Some((first, error)) = failed.first() else { return Ok(()) };
        let (some, all) = (failed.len(), self.stepped.simulations().len());
        let message = format!("{some} of {all} simulations {verb}, the first is simulation {first}: {error}");
        let errors = PyDict::new(py);
        for (number, error) in failed {
            errors.set_item(number, error.to_string())?;
        }
        Err(Class::BadSimulations.error_with(py, message, &[("errors", errors.into_any())]))
    }
}

/// This many rows, or one for all, one after the other.
pub(super) fn rows_of(
    py: Python<'_>,
    name: &str,
    object: &Bound<'_, PyAny>,
    (count, width): (usize, usize),
) -> PyResult<Vec<f64>> {
    let (shape, x) = numbers(py, name, object)?;
    if shape == [count, width] {
        return Ok(x);
    }
    if shape == [width] {
        return Ok(x.repeat(count));
    }
    let asked = format!("{} or ({width},)", shown(&[count, width]));
    Err(Class::Shape.error(py, format!("{name} has shape {}, it must have {asked}", shown(&shape))))
}
