//! Whole-body control, from the objects of `robot_dynamics.whole_body`.

mod contact;
mod objective;
mod solution;

use std::sync::Arc;

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::whole_body::{ContactId, TaskId, WholeBodyControl, WholeBodyLimits};
use robot_dynamics::model::Model;

use self::contact::contact_of;
use self::objective::objective_of;
use self::solution::solution_of;
use super::law::{Controls, Law, check_own, torque};
use crate::errors::exception;
use crate::exclusive::Exclusive;
use crate::numbers::{array, configuration, object, record, shaped, vector};
use crate::robot::Robot;

/// The native half of `robot_dynamics.whole_body.WholeBodyControl`.
#[pyclass(frozen, subclass, module = "robot_dynamics._native")]
pub(crate) struct WholeBody {
    robot: Py<Robot>,
    parts: Exclusive<Parts>,
}

/// The controller, and its contacts and tasks by their numbers.
struct Parts {
    control: WholeBodyControl<Arc<Model>>,
    contacts: Vec<ContactId>,
    tasks: Vec<TaskId>,
}

/// The contact or task of this number.
fn numbered<T: Copy>(kind: &str, all: &[T], number: usize) -> PyResult<T> {
    all.get(number).copied().ok_or_else(|| {
        let count = all.len();
        PyIndexError::new_err(format!("{kind} {number} does not exist; the controller has {count}"))
    })
}

#[pymethods]
impl WholeBody {
    #[new]
    #[pyo3(signature = (robot, *, dissipation=false))]
    fn new(robot: &Bound<'_, Robot>, dissipation: bool) -> Self {
        let control = WholeBodyControl::owning(Arc::new(robot.get().model.clone()));
        let control = if dissipation { control.with_dissipation() } else { control };
        let parts = Parts { control, contacts: Vec::new(), tasks: Vec::new() };
        Self { robot: robot.clone().unbind(), parts: Exclusive::new(parts) }
    }

    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robot.clone_ref(py)
    }

    /// See `limits`.
    fn _limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parts = self.parts.lock(py);
        let WholeBodyLimits { torque, acceleration, velocity, position, rate } = parts.control.limits();
        let bound = |side: usize| position.iter().map(|bounds| bounds[side]).collect::<Vec<_>>();
        record(
            py,
            [
                ("torque", array(py, torque)?),
                ("acceleration", array(py, acceleration)?),
                ("velocity", array(py, velocity)?),
                ("lower", array(py, &bound(0))?),
                ("upper", array(py, &bound(1))?),
                ("rate", object(py, *rate)?),
            ],
        )
    }

    /// See `set_limits`; `None` keeps a limit.
    fn _set_limits(&self, py: Python<'_>, limits: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut parts = self.parts.lock(py);
        let (mut new, nv) = (parts.control.limits().clone(), self.robot.get().model.nv());
        for (name, given) in limits {
            let name: String = name.extract()?;
            if given.is_none() {
                continue;
            }
            if name == "rate" {
                new.rate = given.extract()?;
                continue;
            }
            let (_, entries) = shaped(py, &name, &given, &[nv])?;
            match name.as_str() {
                "torque" => new.torque = entries,
                "acceleration" => new.acceleration = entries,
                "velocity" => new.velocity = entries,
                "lower" => new.position.iter_mut().zip(entries).for_each(|(bounds, x)| bounds[0] = x),
                _ => new.position.iter_mut().zip(entries).for_each(|(bounds, x)| bounds[1] = x),
            }
        }
        parts.control.set_limits(new).map_err(exception)
    }

    /// See `add_contact`.
    fn _add_contact(&self, py: Python<'_>, contact: &Bound<'_, PyAny>) -> PyResult<usize> {
        let contact = contact_of(py, self.robot.get(), contact)?;
        let mut parts = self.parts.lock(py);
        let id = parts.control.add_contact(contact).map_err(exception)?;
        parts.contacts.push(id);
        Ok(id.index())
    }

    /// See `hold_contact`.
    fn _hold_contact(&self, py: Python<'_>, number: usize, is_held: bool) -> PyResult<()> {
        let mut parts = self.parts.lock(py);
        let id = numbered("contact", &parts.contacts, number)?;
        parts.control.hold_contact(id, is_held);
        Ok(())
    }

    /// See `add_task`.
    fn _add_task(
        &self,
        py: Python<'_>,
        objective: &Bound<'_, PyAny>,
        weight: f64,
        level: usize,
    ) -> PyResult<usize> {
        let objective = objective_of(py, self.robot.get(), objective)?;
        let mut parts = self.parts.lock(py);
        let id = parts.control.add_task_at(level, objective, weight).map_err(exception)?;
        parts.tasks.push(id);
        Ok(id.index())
    }

    /// See `set_objective`.
    fn _set_objective(&self, py: Python<'_>, number: usize, objective: &Bound<'_, PyAny>) -> PyResult<()> {
        let objective = objective_of(py, self.robot.get(), objective)?;
        let mut parts = self.parts.lock(py);
        let id = numbered("task", &parts.tasks, number)?;
        *parts.control.objective_mut(id) = objective;
        Ok(())
    }

    /// See `set_weight`.
    fn _set_weight(&self, py: Python<'_>, number: usize, weight: f64) -> PyResult<()> {
        let mut parts = self.parts.lock(py);
        let id = numbered("task", &parts.tasks, number)?;
        parts.control.set_weight(id, weight).map_err(exception)
    }

    /// See `solve`.
    fn _solve<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let robot = self.robot.get();
        let (q, v) = (configuration(py, robot, q)?, vector(py, robot, "v", v)?);
        let solution = py.detach(|| self.parts.lock_detached().control.solve(&q, &v).cloned());
        solution_of(py, &robot.model, &solution.map_err(exception)?)
    }

    /// τ (nv,) of a state.
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        torque(py, self, self.robot.get(), (t, q, v))
    }
}

impl Controls for WholeBody {
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        let controller = Box::new(self.parts.lock(py).control.clone());
        Ok(Law { controller, is_called: false })
    }
}
