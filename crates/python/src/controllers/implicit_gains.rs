//! A law whose gains act at the end of the control period.

use pyo3::prelude::*;
use robot_dynamics::simulation::{ControllerError, WithImplicitGains};

use super::frame_task::effort_limits;
use super::law::{Controls, Law, called_law, check_own, torque};
use crate::errors::exception_of;
use crate::numbers::vector;
use crate::robot::Robot;

/// Makes a law of one's own stable at any stiffness: its gains act at the end of the control period.
///
/// The law's torque at (q, v) is τ₀, and its gains are K = −∂τ/∂q and D = −∂τ/∂v. The result is
/// τ = τ₀ − K h (v + h a) − D h a, with a from (M + h D + h² K) a = τ₀ − C v − g − h K v.
///
/// A robot that is held by τ for h moves as under the linearly implicit Euler method. (Tan, Liu, Turk 2011)
/// The controller is a function of (t, q, v), for `simulate` and for steps of `Simulation`.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// law : function or controller
///     Function of (t, q, v) that returns τ₀ (nv,), not clipped; or a controller of this package.
/// stiffness : array_like, shape (nv,)
///     K [N·m/rad or N/m].
/// damping : array_like, shape (nv,)
///     D [N·m·s/rad or N·s/m].
/// period : float
///     h, how long each torque is held [s].
/// limits : array_like, shape (nv,), optional
///     Largest torques [N·m or N]; default: the effort limits of the robot.
///
/// Raises
/// ------
/// ShapeError
///     An array has the wrong shape.
/// StateError
///     A number is not finite.
/// ControlError
///     A gain is negative, or `period` is not positive.
/// ValueError
///     A limit is negative.
///
/// Examples
/// --------
///
/// >>> robot, home = rd.example("panda"), np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
/// >>> kp, kd = np.full(7, 1e6), np.full(7, 10.0)
/// >>> law = rd.ImplicitGains(robot, lambda t, q, v: kp * (home - q) - kd * v, kp, kd, 1e-3)
/// >>> motion = robot.simulate(home + 0.01, tau=law, duration=1.0, dt=1e-3)
/// >>> bool(np.abs(motion.q[-1] - home).max() < 1e-4)
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct ImplicitGains {
    robot: Py<Robot>,
    law: Py<PyAny>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    period: f64,
    limits: Option<Vec<f64>>,
}

#[pymethods]
impl ImplicitGains {
    #[new]
    #[pyo3(signature = (robot, law, stiffness, damping, period, *, limits=None))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        law: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        period: f64,
        limits: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let own = robot.get();
        let control = Self {
            law: law.clone().unbind(),
            stiffness: vector(py, own, "stiffness", stiffness)?,
            damping: vector(py, own, "damping", damping)?,
            period,
            limits: limits.map(|limits| effort_limits(py, own, limits)).transpose()?,
            robot: robot.clone().unbind(),
        };
        control.law(py, own)?;
        Ok(control)
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

impl ImplicitGains {
    /// The law whose gains these are.
    pub(super) fn inner<'py>(&'py self, py: Python<'py>) -> &'py Bound<'py, PyAny> {
        self.law.bind(py)
    }

    /// These gains around a law.
    pub(super) fn around<'a>(&self, py: Python<'_>, inner: Law<'a>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        let Law { mut controller, is_called } = inner;
        let explicit = move |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| controller.torque(t, q, v, tau);
        let law = WithImplicitGains::new(&robot.model, explicit, &self.stiffness, &self.damping, self.period)
            .map_err(exception_of::<ControllerError>)?;
        let law = match &self.limits {
            Some(limits) => law.with_limits(limits),
            None => law,
        };
        Ok(Law { controller: Box::new(law), is_called })
    }
}

impl Controls for ImplicitGains {
    /// Calls the inner law as a Python function.
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        self.around(py, called_law(self.inner(py), robot), robot)
    }
}
