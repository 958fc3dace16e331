//! Motions of many states at once.

use pyo3::prelude::*;
use robot_dynamics::batch::{Rollout, RolloutError, Torques, rollout};

use crate::errors::Class;
use crate::ffi::{self, Array, Kind, Number, Slices};
use crate::interrupts::{FEW_STEPS, interruptible, until};
use crate::numbers;
use crate::operand::{common_kind, given, shown};
use crate::outcome;
use crate::robot::Robot;
use crate::row::{Operand, Width};
use crate::threads;

#[pymethods]
impl Robot {
    /// See `rollout`.
    #[pyo3(signature = (q, v, tau, each_step, *, step, steps, integrator, dissipation, stride, threads))]
    fn _rollout<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        each_step: bool,
        step: f64,
        steps: usize,
        integrator: &str,
        dissipation: bool,
        stride: usize,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        const Q: Operand = Operand { name: "q", width: Width::Nq };
        const V: Operand = Operand { name: "v", width: Width::Nv };
        let how = Rollout::new(numbers::integrator(py, integrator)?, step, steps)
            .with_dissipation(dissipation)
            .with_stride(stride);
        let threads = threads::count_of(threads)?;
        let mut all = vec![given(py, &self.model, &Q, 0, q, None)?, given(py, &self.model, &V, 0, v, None)?];
        if let Some(tau) = tau {
            all.push(given(py, &self.model, &Operand { name: "tau", width: Width::Nv }, 0, tau, None)?);
        }
        let kind = common_kind(py, &all)?;
        let arrays = all.into_iter().map(|given| given.array).collect();
        let call = Call { py, robot: self, how, each_step, threads, arrays };
        if kind == Kind::F32 { call.run::<f32>() } else { call.run::<f64>() }
    }
}

struct Call<'a, 'py> {
    py: Python<'py>,
    robot: &'a Robot,
    how: Rollout,
    each_step: bool,
    threads: Option<usize>,
    /// q, v and the torques, if any, in the shape of the whole batch.
    arrays: Vec<Bound<'py, PyAny>>,
}

impl<'py> Call<'_, 'py> {
    fn run<T: Number>(self) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let Self { py, robot, how, ref arrays, .. } = self;
        let (nq, nv) = (robot.model.nq(), robot.model.nv());
        let Some(shape) = Array::of(&arrays[0]).map(|array| array.shape.to_vec()) else {
            return Ok(Vec::new());
        };
        let lead = &shape[..shape.len() - 1];
        // Moved in place, so copies of what is given.
        let copy = |array: &Bound<'py, PyAny>| array.call_method1("copy", ("C",));
        let table = |width: usize| [lead, &[how.samples(), width]].concat();
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
        let Some(slices) = ffi::slices::<T>(&[tau, none, none, none], &written) else {
            return Err(Class::Shape.error(py, "the arrays cannot be read where they lie"));
        };
        let bad = self.moved(lead.iter().product(), slices)?;
        if bad.is_empty() {
            return Ok(moved);
        }
        Err(outcome::bad_states(py, &bad, describe_bad(&bad, lead), numbers::object(py, moved)?)?)
    }

    /// Moves the states; those that went wrong.
    fn moved<T: Number>(&self, states: usize, slices: Slices<'_, T>) -> PyResult<Vec<usize>> {
        let ([tau, ..], [q, v, q_trajectory, v_trajectory]) = slices;
        let torques = match self.arrays.len() {
            2 => Torques::Zero,
            _ if self.each_step => Torques::EachStep(tau),
            _ => Torques::Held(tau),
        };
        let work = states * self.how.steps;
        let threads = self.threads.unwrap_or_else(|| threads_for(work));
        let model = &self.robot.model;
        let mut memory = T::batches(self.robot).take(model, threads)?;
        let (workspace, how) = (&mut memory.workspace, &self.how);
        let outcome = interruptible(self.py, work <= FEW_STEPS, |cancelled| {
            rollout(model, workspace, how, torques, q, v, (q_trajectory, v_trajectory), &until(cancelled))
        });
        T::batches(self.robot).give(memory);
        match outcome? {
            Ok(()) => Ok(Vec::new()),
            Err(RolloutError::BadStates(bad)) => Ok(bad.states),
            Err(error) => Err(Class::Simulation.error(self.py, error)),
        }
    }
}

/// Threads for so many steps of all states together, where the caller says nothing.
pub(crate) fn threads_for(work: usize) -> usize {
    if work <= 256 { 1 } else { threads::default_count() }
}

/// What is wrong with some states of a rollout.
#[cold]
pub(crate) fn describe_bad(bad: &[usize], lead: &[usize]) -> String {
    let (count, states) = (bad.len(), lead.iter().product::<usize>());
    let verb = if count == 1 { "is" } else { "are" };
    format!(
        "{count} of {states} states {verb} bad, the first is state {} of {}: a number given or computed for it on \
         the way is not finite; try a smaller step; `.result` has the others",
        bad[0],
        shown(lead)
    )
}
