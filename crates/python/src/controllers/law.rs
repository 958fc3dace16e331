//! A law that a simulation runs, and the motion that it follows.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use robot_dynamics::simulation::{CallbackError, Controller, ControllerError};

use crate::errors::{Class, exception};
use crate::numbers::{array, configuration, shaped, vector};
use crate::robot::Robot;

/// A law that a simulation runs.
pub(crate) struct Law<'a> {
    pub(crate) controller: Box<dyn Controller + Send + 'a>,
    /// Whether its reference is a Python function.
    pub(crate) is_called: bool,
}

/// A controller of Python, which makes a law.
pub(crate) trait Controls {
    /// The law for this robot; an error if the controller was made for another.
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>>;
}

/// The law of a Python function of (t, q, v) that returns τ.
pub(crate) fn called_law<'a>(function: &Bound<'_, PyAny>, robot: &Robot) -> Law<'a> {
    let law = CalledLaw { function: function.clone().unbind(), nv: robot.model.nv() };
    Law { controller: Box::new(law), is_called: true }
}

struct CalledLaw {
    function: Py<PyAny>,
    nv: usize,
}

impl Controller for CalledLaw {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        Python::attach(|py| {
            let given = (t, array(py, q)?, array(py, v)?);
            let found = self.function.bind(py).call1(given)?;
            let (_, numbers) = shaped(py, "the controller's torque", &found, &[self.nv])?;
            tau.copy_from_slice(&numbers);
            PyResult::Ok(())
        })
        .map_err(|error| ControllerError::Callback(CallbackError::new(error)))
    }
}

/// Refuses a robot that the law was not made for.
pub(super) fn check_own(py: Python<'_>, own: &Robot, robot: &Robot) -> PyResult<()> {
    if own.model.fingerprint() == robot.model.fingerprint() {
        return Ok(());
    }
    let (own, other) = (own.model.name(), robot.model.name());
    let message = format!("the controller is of robot `{own}`, not of this `{other}`: make one for it");
    Err(Class::Control.error(py, message))
}

/// τ of one state.
pub(super) fn torque<'py>(
    py: Python<'py>,
    controls: &impl Controls,
    robot: &Robot,
    (t, q, v): (f64, &Bound<'py, PyAny>, &Bound<'py, PyAny>),
) -> PyResult<Bound<'py, PyAny>> {
    let Law { mut controller, .. } = controls.law(py, robot)?;
    let (q, v) = (configuration(py, robot, q)?, vector(py, robot, "v", v)?);
    let mut tau = vec![0.0; robot.model.nv()];
    match controller.torque(t, &q, &v, &mut tau) {
        Ok(()) => array(py, &tau),
        Err(error) => Err(match raised(py, &error) {
            Some(own) => own,
            None => exception(error),
        }),
    }
}

/// The exception that Python raised in a law's reference.
fn raised(py: Python<'_>, error: &ControllerError) -> Option<PyErr> {
    let ControllerError::Callback(callback) = error else { return None };
    callback.downcast_ref::<PyErr>().map(|own| own.clone_ref(py))
}

/// The parts of a reference at one time: the position, and the velocity and acceleration if they are given.
#[allow(clippy::type_complexity)] // a place, and maybe two more
pub(super) fn parts<'py>(
    given: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>)> {
    match given.cast::<PyTuple>() {
        Ok(all) if all.len() == 3 && all.get_item(0)?.extract::<f64>().is_err() => {
            Ok((all.get_item(0)?, Some((all.get_item(1)?, all.get_item(2)?))))
        }
        _ => Ok((given.clone(), None)),
    }
}

/// The reference of a law: a constant, or a function of t.
pub(crate) enum ReferenceSource<T> {
    Constant(T),
    Called(Py<PyAny>),
}

impl<T: Clone> ReferenceSource<T> {
    /// A function, or a constant that `read` reads.
    pub(super) fn of<'py>(
        given: &Bound<'py, PyAny>,
        read: impl FnOnce(&Bound<'py, PyAny>) -> PyResult<T>,
    ) -> PyResult<Self> {
        if given.is_callable() {
            return Ok(Self::Called(given.clone().unbind()));
        }
        read(given).map(Self::Constant)
    }

    pub(super) fn is_called(&self) -> bool {
        matches!(self, Self::Called(_))
    }

    /// The reference at a time.
    pub(super) fn at(&self, t: f64, read: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>) -> PyResult<T> {
        match self {
            Self::Constant(value) => Ok(value.clone()),
            Self::Called(function) => Python::attach(|py| read(&function.bind(py).call1((t,))?)),
        }
    }

    pub(super) fn share(&self, py: Python<'_>) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(value.clone()),
            Self::Called(function) => Self::Called(function.clone_ref(py)),
        }
    }
}
