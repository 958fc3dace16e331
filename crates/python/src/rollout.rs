//! Motions of many states at once.

use std::collections::HashMap;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::batch::{
    self, Rollout, RolloutError, RolloutStates, StepperRollout, rollout, rollout_by_stepper,
};
use robot_dynamics::simulation::{Integrator, RunOptions, Simulation, Stepper};

use crate::errors::{Class, exception};
use crate::ffi::{self, Array, Kind, Slices};
use crate::interrupts::{FEW_STEPS, interruptible, until};
use crate::number::Number;
use crate::operand::{common_kind, given, shown};
use crate::robot::Robot;
use crate::row::{Operand, Width};
use crate::simulation::options::Setup;
use crate::simulation::set_controls;
use crate::simulation::torques::Torques;
use crate::{numbers, outcome, threads};

#[pymethods]
impl Robot {
    /// See `rollout`.
    #[pyo3(signature = (q, v, tau, each_step, *, steps, stride, threads, controls, **options))]
    fn _rollout<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        each_step: bool,
        steps: usize,
        stride: usize,
        threads: Option<&Bound<'py, PyAny>>,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        const Q: Operand = Operand { name: "q", width: Width::Nq };
        const V: Operand = Operand { name: "v", width: Width::Nv };
        let prepared = Setup::of(options)?.refuse_adaptive(py)?.with_prepared(py, self, |simulation| {
            set_controls(self, simulation, controls.clone())?;
            let how = (simulation.dt(), simulation.dissipates());
            let (method, reason) = (simulation.method(), simulation.reason().to_owned());
            Ok((how, method, reason, simulation.stepper()))
        })?;
        let ((step, dissipation), method, reason, stepper) = prepared;
        let how = Steps { step, steps, dissipation, stride };
        let threads = threads::count_of(threads)?;
        let mut all = vec![given(py, &self.model, &Q, 0, q, None)?, given(py, &self.model, &V, 0, v, None)?];
        if let Some(tau) = tau {
            all.push(given(py, &self.model, &Operand { name: "tau", width: Width::Nv }, 0, tau, None)?);
        }
        let kind = common_kind(py, &all)?;
        let arrays = all.into_iter().map(|given| given.array).collect();
        // If a state fails, a simulation from it finds the reason.
        let single = || {
            Setup::of(options)?.with_prepared(py, self, |simulation| {
                let mut simulation = simulation.clone();
                set_controls(self, &mut simulation, controls.clone())?;
                Ok(simulation)
            })
        };
        let call = RolloutRequest { py, robot: self, how, each_step, threads, arrays, single: &single };
        let is_f32 = kind == Kind::F32;
        match stepper.row() {
            Some(row) if is_f32 => call.run::<f32>(|states, slices| call.moved(row, states, slices)),
            Some(row) => call.run::<f64>(|states, slices| call.moved(row, states, slices)),
            None if is_f32 => Err(PyTypeError::new_err(format!(
                "this simulation ({method}: {reason}) computes in float64; give it q.astype(float)"
            ))),
            None => call.run(|states, slices| call.moved_by(&stepper, states, slices)),
        }
    }
}

/// The steps of a rollout, and how many of them are kept.
#[derive(Clone, Copy)]
struct Steps {
    step: f64,
    steps: usize,
    dissipation: bool,
    stride: usize,
}

struct RolloutRequest<'a, 'py> {
    py: Python<'py>,
    robot: &'a Robot,
    how: Steps,
    each_step: bool,
    threads: Option<usize>,
    /// q, v and the torques, if any, in the shape of the whole batch.
    arrays: Vec<Bound<'py, PyAny>>,
    /// A simulation as that of each state.
    single: &'a dyn Fn() -> PyResult<Simulation>,
}

impl<'py> RolloutRequest<'_, 'py> {
    fn run<T: Number>(
        &self,
        moved_by: impl FnOnce(usize, Slices<'_, T>) -> PyResult<Vec<usize>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let Self { py, robot, how, ref arrays, .. } = *self;
        let (nq, nv) = (robot.model.nq(), robot.model.nv());
        let Some(shape) = Array::of(&arrays[0]).map(|array| array.shape.to_vec()) else {
            return Ok(Vec::new());
        };
        let lead = &shape[..shape.len() - 1];
        // They are moved in place, so the arguments are copied.
        let copy = |array: &Bound<'py, PyAny>| array.call_method1("copy", ("C",));
        let samples = how.steps.checked_div(how.stride).unwrap_or(0);
        let table = |width: usize| [lead, &[samples, width]].concat();
        let moved = vec![
            copy(&arrays[0])?,
            copy(&arrays[1])?,
            outcome::new::<T>(py, &table(nq)),
            outcome::new::<T>(py, &table(nv)),
        ];
        let none = Array::NONE;
        let header = |object| Array::of(object).unwrap_or(none);
        let tau = arrays.get(2).map_or(none, header);
        let written = [0, 1, 2, 3].map(|k| header(&moved[k]));
        let Some(slices) = ffi::slices::<T>(&[tau, none, none, none, none], &written) else {
            return Err(Class::Shape.error(py, "the arrays cannot be read where they lie"));
        };
        let bad = moved_by(lead.iter().product(), slices)?;
        if bad.is_empty() {
            return Ok(moved);
        }
        let reason = self.reason(bad[0])?.unwrap_or_else(|| NOT_FINITE.to_owned());
        Err(outcome::bad_states(py, &bad, describe_bad(&bad, lead, &reason), numbers::object(py, moved)?)?)
    }

    /// The error of a simulation from a state of the batch; `None` if it reaches the end.
    #[cold]
    fn reason(&self, state: usize) -> PyResult<Option<String>> {
        let (py, model, steps) = (self.py, &self.robot.model, self.how.steps);
        let row = |array: &Bound<'py, PyAny>, shape: (usize, usize)| {
            let rows =
                array.call_method1("astype", ("f8",))?.call_method1("reshape", ((-1, shape.0, shape.1),))?;
            PyResult::Ok(numbers::numbers(py, "a row", &rows.get_item(state)?)?.1)
        };
        let (q, v) = (row(&self.arrays[0], (1, model.nq()))?, row(&self.arrays[1], (1, model.nv()))?);
        let nv = model.nv();
        let mut torques = match self.arrays.get(2) {
            None => Torques::Held(vec![0.0; nv]),
            Some(tau) if self.each_step => {
                Torques::EachStep { rows: row(tau, (steps, nv))?, nv, step: self.how.step }
            }
            Some(tau) => Torques::Held(row(tau, (1, nv))?),
        };
        let mut simulation = (self.single)()?;
        // It ends at the end of the batch's motion at the latest, and mostly long before.
        let run = py
            .detach(|| simulation.run_steps_from(&q, &v, steps, RunOptions::new().controller(&mut torques)));
        Ok(run.err().map(|failure| failure.error.to_string()))
    }

    /// Moves the states by a row of the table. Returns those that failed.
    fn moved<T: Number>(
        &self,
        row: Integrator,
        states: usize,
        slices: Slices<'_, T>,
    ) -> PyResult<Vec<usize>> {
        let ([tau, ..], [q, v, q_trajectory, v_trajectory]) = slices;
        let (work, torques) = (states * self.how.steps, self.torques(tau));
        let threads = self.threads.unwrap_or_else(|| threads_for(work));
        let model = &self.robot.model;
        let mut memory = T::batches(self.robot).take(model, threads)?;
        let workspace = &mut memory.workspace;
        let how = Rollout::new(row, self.how.step, self.how.steps)
            .with_dissipation(self.how.dissipation)
            .with_stride(self.how.stride);
        let outcome = interruptible(self.py, work <= FEW_STEPS, |cancelled| {
            let states = RolloutStates { q, v, q_trajectory, v_trajectory };
            rollout(model, workspace, &how, torques, states, Some(&until(cancelled)))
        });
        T::batches(self.robot).give(memory);
        bad_states(outcome?)
    }

    /// The same with a stepper.
    fn moved_by<S: Stepper + Clone + Sync>(
        &self,
        stepper: &S,
        states: usize,
        slices: Slices<'_, f64>,
    ) -> PyResult<Vec<usize>> {
        let ([tau, ..], [q, v, q_trajectory, v_trajectory]) = slices;
        let (work, torques) = (states * self.how.steps, self.torques(tau));
        let threads = self.threads.unwrap_or_else(threads::default_count);
        let model = &self.robot.model;
        let memory = f64::batches(self.robot).take(model, threads)?;
        let workspace = &memory.workspace;
        let how = StepperRollout::new(stepper, self.how.step, self.how.steps)
            .with_dissipation(self.how.dissipation)
            .with_stride(self.how.stride);
        // A step with contacts takes a hundred times as long as one without.
        let outcome = interruptible(self.py, work <= FEW_STEPS / 100, |cancelled| {
            let trajectory = (q_trajectory, v_trajectory);
            let states = RolloutStates { q, v, q_trajectory: trajectory.0, v_trajectory: trajectory.1 };
            rollout_by_stepper(model, workspace, &how, torques, states, Some(&until(cancelled)))
        });
        f64::batches(self.robot).give(memory);
        bad_states(outcome?)
    }

    fn torques<'a, T>(&self, tau: &'a [T]) -> batch::Torques<'a, T> {
        match self.arrays.len() {
            2 => batch::Torques::Zero,
            _ if self.each_step => batch::Torques::EachStep(tau),
            _ => batch::Torques::Held(tau),
        }
    }
}

/// The states that the rollout could not advance.
fn bad_states(outcome: Result<(), RolloutError>) -> PyResult<Vec<usize>> {
    match outcome {
        Ok(()) => Ok(Vec::new()),
        Err(RolloutError::BadStates(bad)) => Ok(bad.states),
        Err(error) => Err(exception(error)),
    }
}

/// The default number of threads for this many steps of all states together.
pub(crate) fn threads_for(work: usize) -> usize {
    if work <= 256 { 1 } else { threads::default_count() }
}

/// The reason of a failed state if no other is known.
pub(crate) const NOT_FINITE: &str =
    "a number given or computed for it on the way is not finite; try a smaller step";

/// The error of some states of a rollout, with the reason of the first.
#[cold]
pub(crate) fn describe_bad(bad: &[usize], lead: &[usize], reason: &str) -> String {
    let (count, states) = (bad.len(), lead.iter().product::<usize>());
    let verb = if count == 1 { "is" } else { "are" };
    format!(
        "{count} of {states} states {verb} bad, the first is state {} of {}: {reason}; `.result` has the others",
        bad[0],
        shown(lead)
    )
}
