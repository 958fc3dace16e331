//! The derivatives of one step.

use std::collections::HashMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::derivatives::{LinearizedStep, RobotState, linearize_step, linearize_stepper};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{StepForces, StepWorkspace, Stepper};

use crate::errors::exception;
use crate::ffi::{self, Array};
use crate::numbers::{configuration, vector, vector_or_zeros};
use crate::outcome;
use crate::results::MOST_RESULTS;
use crate::robot::Robot;
use crate::simulation::options::Setup;
use crate::simulation::set_controls;

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
        let Some((_, [by_state, by_force, ..])) = ffi::slices::<f64>(&[Array::NONE; 4], &written) else {
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
