//! The derivatives of one step.

use std::collections::HashMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::batch::{self, LinearizeInputs, RolloutError};
use robot_dynamics::derivatives::{LinearizedStep, RobotState, linearize_step, linearize_stepper};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{SimulationStepper, StepForces, StepWorkspace, Stepper};

use crate::errors::{Class, exception};
use crate::ffi::{self, Array};
use crate::number::Number;
use crate::numbers::{configuration, object, vector, vector_or_zeros};
use crate::results::{MOST_OPERANDS, MOST_RESULTS};
use crate::robot::Robot;
use crate::rollout::{NOT_FINITE, describe_bad};
use crate::simulation::options::Setup;
use crate::simulation::set_controls;
use crate::{outcome, threads};

/// The number of states between two checks for Ctrl-C, and up to which one thread computes all.
const EXACT: (usize, usize) = (4096, 32);

/// The same for the derivatives of other steps.
const OF_STEPPER: (usize, usize) = (64, 1);

#[pymethods]
impl Robot {
    /// See `linearize_step`.
    #[pyo3(signature = (q, v, tau, controls, **options))]
    fn _linearize_step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let prepared = Setup::of(options)?.refuse_adaptive(py)?.with_prepared(py, self, |simulation| {
            set_controls(self, simulation, controls)?;
            Ok((simulation.stepper(), simulation.dt(), simulation.dissipates()))
        })?;
        let (stepper, h, dissipates) = prepared;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let (model, nv, forces) = (&self.model, self.model.nv(), StepForces::new(&tau, dissipates));
        let arrays = [outcome::new::<f64>(py, &[2 * nv, 2 * nv]), outcome::new::<f64>(py, &[2 * nv, nv])];
        let mut written = [Array::NONE; MOST_RESULTS];
        written.iter_mut().zip(&arrays).for_each(|(to, array)| *to = Array::of(array).unwrap_or(Array::NONE));
        let Some((_, [by_state, by_force, ..])) = ffi::slices::<f64>(&[Array::NONE; MOST_OPERANDS], &written)
        else {
            unreachable!("new arrays are slices")
        };
        match stepper.row() {
            Some(row) => self.scratch.with(model, |scratch| {
                let workspace = scratch.linearized(model);
                let out = LinearizedStep { by_state, by_force };
                linearize_step(model, row, workspace, &forces, h, RobotState { q: &q, v: &v }, out)
                    .map_err(exception)
            }),
            None => of_stepper(model, stepper, &forces, h, (&q, &v), (by_state, by_force)),
        }?;
        let [by_state, by_force] = arrays;
        Ok((by_state, by_force))
    }

    /// See `linearize_step`. Plain float64 arrays with a row for each state of a batch of shape `lead`; tau
    /// may be empty.
    #[pyo3(signature = (q, v, tau, controls, lead, threads, **options))]
    fn _linearize_steps<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        controls: Option<HashMap<String, f64>>,
        lead: Vec<usize>,
        threads: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let prepared = Setup::of(options)?.refuse_adaptive(py)?.with_prepared(py, self, |simulation| {
            set_controls(self, simulation, controls.clone())?;
            Ok((simulation.stepper(), simulation.dt(), simulation.dissipates()))
        })?;
        let (stepper, step, dissipation) = prepared;
        let nv = self.model.nv();
        let arrays = [(2 * nv, 2 * nv), (2 * nv, nv)]
            .map(|(rows, columns)| outcome::new::<f64>(py, &[&lead[..], &[rows, columns]].concat()));
        let header = |array| Array::of(array).unwrap_or(Array::NONE);
        let read = [header(q), header(v), header(tau), Array::NONE, Array::NONE];
        let mut written = [Array::NONE; MOST_RESULTS];
        written.iter_mut().zip(&arrays).for_each(|(to, array)| *to = header(array));
        let Some(([q_rows, v_rows, tau_rows, ..], [by_state, by_force, ..])) =
            ffi::slices::<f64>(&read, &written)
        else {
            return Err(Class::Shape.error(py, "the arrays cannot be read where they lie"));
        };
        let inputs = LinearizeInputs { step, dissipation, q: q_rows, v: v_rows, tau: tau_rows };
        let has_tau = !tau_rows.is_empty();
        let threads = threads::count_of(threads)?;
        let bad =
            self.linearize_rows(py, &stepper, inputs, LinearizedStep { by_state, by_force }, threads)?;
        let [by_state, by_force] = arrays;
        let Some(&state) = bad.first() else { return Ok((by_state, by_force)) };
        // The call of this state alone finds the reason.
        let tau = has_tau.then(|| tau.get_item(state)).transpose()?;
        let (q, v) = (q.get_item(state)?, v.get_item(state)?);
        #[allow(clippy::used_underscore_items)] // Python's name of it
        let single = self._linearize_step(py, &q, &v, tau.as_ref(), controls, options);
        let reason = single.err().map_or_else(|| NOT_FINITE.to_owned(), |error| error.value(py).to_string());
        let result = object(py, vec![by_state, by_force])?;
        Err(outcome::bad_states(py, &bad, describe_bad(&bad, &lead, &reason), result)?)
    }
}

impl Robot {
    /// Linearises a step of each state. Returns the bad ones, ascending; their matrices are NaN.
    fn linearize_rows(
        &self,
        py: Python<'_>,
        stepper: &SimulationStepper,
        inputs: LinearizeInputs<'_>,
        results: LinearizedStep<'_>,
        threads: Option<usize>,
    ) -> PyResult<Vec<usize>> {
        let LinearizedStep { by_state, by_force } = results;
        let (model, nq, nv) = (&self.model, self.model.nq(), self.model.nv());
        let (count, square) = (inputs.q.len() / nq.max(1), nv * nv);
        let (at_once, few) = if stepper.row().is_some() { EXACT } else { OF_STEPPER };
        let threads = threads.unwrap_or_else(|| if count <= few { 1 } else { threads::default_count() });
        let memory = f64::batches(self).take(model, threads)?;
        let mut bad = Vec::new();
        for first in (0..count).step_by(at_once) {
            let states = at_once.min(count - first);
            let rows = |table: &'_ [f64], width: usize| match table.len() {
                0 => 0..0,
                _ => first * width..(first + states) * width,
            };
            let part = LinearizeInputs {
                q: &inputs.q[rows(inputs.q, nq)],
                v: &inputs.v[rows(inputs.v, nv)],
                tau: &inputs.tau[rows(inputs.tau, nv)],
                ..inputs
            };
            let out = LinearizedStep {
                by_state: &mut by_state[first * 4 * square..][..states * 4 * square],
                by_force: &mut by_force[first * 2 * square..][..states * 2 * square],
            };
            let workspace = &memory.workspace;
            match py.detach(|| match stepper.row() {
                Some(row) => batch::linearize_step(model, workspace, row, part, out),
                None => batch::linearize_stepper(model, workspace, stepper, part, out),
            }) {
                Ok(()) => {}
                Err(RolloutError::BadStates(found)) => {
                    bad.extend(found.states.into_iter().map(|state| first + state));
                }
                Err(error) => return Err(exception(error)),
            }
            py.check_signals()?;
        }
        f64::batches(self).give(memory);
        // The library's steps normalise quaternions; calls of this package refuse them.
        for state in 0..count {
            if !self.has_unit_quaternions(&inputs.q[state * nq..][..nq]) {
                by_state[state * 4 * square..][..4 * square].fill(f64::NAN);
                by_force[state * 2 * square..][..2 * square].fill(f64::NAN);
                bad.push(state);
            }
        }
        bad.sort_unstable();
        bad.dedup();
        Ok(bad)
    }
}

/// The derivatives of a step. Its contacts are those that a step from this state finds.
fn of_stepper<S: Stepper + Clone>(
    model: &Model,
    mut stepper: S,
    forces: &StepForces<'_>,
    h: f64,
    (q, v): (&[f64], &[f64]),
    (by_state, by_force): (&mut [f64], &mut [f64]),
) -> PyResult<()> {
    let workspace = &mut StepWorkspace::new(model);
    stepper.step(model, workspace, forces, h, &mut q.to_vec(), &mut v.to_vec()).map_err(exception)?;
    let out = LinearizedStep { by_state, by_force };
    linearize_stepper(model, &mut stepper, workspace, forces, h, RobotState { q, v }, out)
        .map(|_| ())
        .map_err(exception)
}
