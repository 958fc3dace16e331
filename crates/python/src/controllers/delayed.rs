//! A law whose torque arrives late.

use pyo3::prelude::*;
use robot_dynamics::simulation::ControllerError;

use super::law::{Controls, Law, called_law, check_own};
use crate::errors::exception_of;
use crate::robot::Robot;

/// A law whose torque acts after a delay, as through a bus or a computer.
///
/// τ(t) is the torque of the law's last call at or before t − d, and 0 until the first torque arrives. It is
/// a torque of `simulate`, which calls it at every step.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// law : function or controller
///     Function of (t, q, v) that returns τ (nv,), or a controller of this package.
/// delay : float
///     d [s].
///
/// Raises
/// ------
/// ControlError
///     The delay is not positive.
///
/// Examples
/// --------
///
/// >>> robot = rd.example("two_r")
/// >>> late = rd.Delayed(robot, lambda t, q, v: [1.0, 0.0], 0.05)
/// >>> motion = robot.simulate([0.0, 0.0], tau=late, duration=0.1, dt=0.01)
/// >>> motion.tau[:, 0].tolist()
/// [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct Delayed {
    robot: Py<Robot>,
    law: Py<PyAny>,
    delay: f64,
}

#[pymethods]
impl Delayed {
    #[new]
    fn new(py: Python<'_>, robot: &Bound<'_, Robot>, law: &Bound<'_, PyAny>, delay: f64) -> PyResult<Self> {
        let control = Self { law: law.clone().unbind(), delay, robot: robot.clone().unbind() };
        control.law(py, robot.get())?;
        Ok(control)
    }
}

impl Delayed {
    /// The law that is late.
    pub(super) fn inner<'py>(&'py self, py: Python<'py>) -> &'py Bound<'py, PyAny> {
        self.law.bind(py)
    }

    /// This delay of a law.
    pub(super) fn around<'a>(&self, py: Python<'_>, inner: Law<'a>, robot: &Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        let Law { mut controller, is_called } = inner;
        let law = move |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| controller.torque(t, q, v, tau);
        let late = robot_dynamics::simulation::Delayed::new(law, self.delay)
            .map_err(exception_of::<ControllerError>)?;
        Ok(Law { controller: Box::new(late), is_called })
    }
}

impl Controls for Delayed {
    /// Calls the inner law as a Python function.
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        self.around(py, called_law(self.inner(py), robot), robot)
    }
}
