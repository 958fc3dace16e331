//! Convex sets that contain all positions of a frame.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::bounds::{region, search};
use crate::errors::{Class, exception};
use crate::numbers::{array, several};
use crate::outcome;
use crate::robot::Robot;

/// The set of `robot_dynamics.certified.ReachableSet`.
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct ReachableSet(robot_dynamics_certified::ReachableSet<'static>);

#[pymethods]
impl ReachableSet {
    /// See `ReachableSet.farthest`: the proven and the attained number, and a configuration.
    fn _farthest<'py>(
        &self,
        py: Python<'py>,
        direction: &Bound<'py, PyAny>,
    ) -> PyResult<(f64, f64, Bound<'py, PyAny>)> {
        let direction: [f64; 3] = several("direction", direction)?;
        if let Some(k) = direction.iter().position(|x| !x.is_finite()) {
            let message = format!("direction[{k}] is {}; every number must be finite", direction[k]);
            return Err(Class::State.error(py, message));
        }
        let farthest = py.detach(|| self.0.farthest(direction));
        Ok((farthest.proven, farthest.attained, array(py, &farthest.q)?))
    }

    /// The bounds of x, y and z.
    fn _box<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let bounds = py.detach(|| self.0.bounding_box());
        let rows: Vec<f64> =
            bounds.iter().map(|x| x.lower()).chain(bounds.iter().map(|x| x.upper())).collect();
        outcome::filled(py, &[2, 3], &rows)
    }
}

#[pymethods]
impl Robot {
    /// See `certify_reach`.
    fn _certify_reach(
        &self,
        py: Python<'_>,
        frame: &Bound<'_, PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
        cells: usize,
        threads: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<ReachableSet> {
        let frame = self.frame_of(frame)?;
        let q = region(py, self, lower, upper)?;
        if !(cells.is_power_of_two() && (2..=1024).contains(&cells)) {
            return Err(PyValueError::new_err(format!(
                "cells = {cells} must be a power of two from 2 to 1024"
            )));
        }
        let set = search(py, (0.0, usize::MAX), threads, |options| {
            let set = robot_dynamics_certified::ReachableSet::new(&self.model, &q, frame, cells, options)?;
            Ok(set.into_owned())
        })?;
        set.map(ReachableSet).map_err(exception::<robot_dynamics_certified::EnclosureError>)
    }
}
