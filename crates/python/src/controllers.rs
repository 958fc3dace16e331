//! Laws of control, which a simulation runs without calling Python but for what they follow.

mod computed_torque;
mod pd;
mod task;

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use robot_dynamics::simulation::Controller;

use crate::errors::Class;
use crate::numbers::{array, configuration, vector};
use crate::robot::Robot;

pub(crate) use self::computed_torque::ComputedTorque;
pub(crate) use self::pd::GravityCompensatedPd;
pub(crate) use self::task::TaskControl;

/// A law that a simulation runs.
pub(crate) struct Law<'a> {
    pub(crate) controller: Box<dyn Controller + Send + 'a>,
    /// Whether what it follows is a function of Python's.
    pub(crate) is_called: bool,
}

/// The law for this robot, if the object is one.
pub(crate) fn law_of<'a>(
    py: Python<'_>,
    robot: &'a Robot,
    object: &Bound<'_, PyAny>,
) -> PyResult<Option<Law<'a>>> {
    if let Ok(law) = object.cast::<GravityCompensatedPd>() {
        let controller = Box::new(law.get().law(py, robot)?);
        return Ok(Some(Law { controller, is_called: false }));
    }
    if let Ok(law) = object.cast::<ComputedTorque>() {
        return law.get().law(py, robot).map(Some);
    }
    if let Ok(law) = object.cast::<TaskControl>() {
        return law.get().law(py, robot).map(Some);
    }
    Ok(None)
}

/// Refuses a robot that a law is not of.
fn check_own(py: Python<'_>, own: &Robot, robot: &Robot) -> PyResult<()> {
    if own.model.fingerprint() == robot.model.fingerprint() {
        return Ok(());
    }
    let (own, other) = (own.model.name(), robot.model.name());
    let message = format!("the controller is of robot `{own}`, not of this `{other}`: make one for it");
    Err(Class::Control.error(py, message))
}

/// τ of one state.
fn torque<'py>(
    py: Python<'py>,
    robot: &Robot,
    controller: &mut dyn Controller,
    (t, q, v): (f64, &Bound<'py, PyAny>, &Bound<'py, PyAny>),
) -> PyResult<Bound<'py, PyAny>> {
    let (q, v) = (configuration(py, robot, q)?, vector(py, robot, "v", v)?);
    let mut tau = vec![0.0; robot.model.nv()];
    match controller.torque(t, &q, &v, &mut tau) {
        Ok(()) => array(py, &tau),
        Err(error) => Err(match raised(py, &error) {
            Some(own) => own,
            None => Class::Control.error(py, error),
        }),
    }
}

/// What Python itself had raised in a law's reference.
fn raised(py: Python<'_>, error: &robot_dynamics::simulation::ControllerError) -> Option<PyErr> {
    let robot_dynamics::simulation::ControllerError::Callback(callback) = error else { return None };
    callback.downcast_ref::<PyErr>().map(|own| own.clone_ref(py))
}

/// What a law follows at a time: the place, and velocity and acceleration where they are given.
#[allow(clippy::type_complexity)] // a place, and maybe two more
fn parts<'py>(
    given: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>)> {
    match given.cast::<PyTuple>() {
        Ok(all) if all.len() == 3 && all.get_item(0)?.extract::<f64>().is_err() => {
            Ok((all.get_item(0)?, Some((all.get_item(1)?, all.get_item(2)?))))
        }
        _ => Ok((given.clone(), None)),
    }
}

/// What a law follows: the same all the time, or what a function of t gives.
pub(crate) enum Followed<T> {
    Constant(T),
    Called(Py<PyAny>),
}

impl<T: Clone> Followed<T> {
    fn is_called(&self) -> bool {
        matches!(self, Self::Called(_))
    }

    /// What is followed at a time.
    fn at(&self, t: f64, read: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>) -> PyResult<T> {
        match self {
            Self::Constant(value) => Ok(value.clone()),
            Self::Called(function) => Python::attach(|py| read(&function.bind(py).call1((t,))?)),
        }
    }

    fn share(&self, py: Python<'_>) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(value.clone()),
            Self::Called(function) => Self::Called(function.clone_ref(py)),
        }
    }
}
