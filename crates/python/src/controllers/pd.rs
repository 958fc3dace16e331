//! A spring to a pose, damping, and gravity compensation.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::simulation::{ControllerError, GravityAt};

use super::frame_task::effort_limits;
use super::law::{Controls, Law, check_own, torque};
use crate::errors::exception_of;
use crate::numbers::{configuration, vector};
use crate::robot::Robot;

/// Holds a pose: τ = g + Kp (qʳ ⊖ q) − Kd v with diagonal gains, each coordinate cut off at its effort limit.
///
/// Coordinates without a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0. The
/// controller is a function of (t, q, v); in `simulate` it runs in the library.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// target : array_like, shape (nq,)
///     Configuration qʳ to hold.
/// stiffness : array_like, shape (nv,)
///     Kp [N·m/rad or N/m].
/// damping : array_like, shape (nv,)
///     Kd [N·m·s/rad or N·s/m].
/// limits : array_like, shape (nv,), optional
///     Largest torques [N·m or N]; default: the effort limits of the robot.
/// gravity_at : {"target", "state"}
///     Configuration at which g is computed: `target`, or that of the robot.
/// implicit_period : float, optional
///     How long each torque is held [s]. The gains then act at the end of that time, and the law is stable at
///     any stiffness: see `ImplicitGains`.
///
/// Raises
/// ------
/// StateError
///     A number is not finite, or `target` is not a configuration.
/// ShapeError
///     An array has the wrong shape.
/// ControlError
///     `implicit_period` is not positive, or a gain is negative with it.
/// ValueError
///     A limit is negative, or `gravity_at` is unknown.
///
/// Examples
/// --------
///
/// >>> robot = rd.example("panda")
/// >>> hold = rd.GravityCompensatedPd(robot, np.full(7, 0.2), np.full(7, 50.0), np.full(7, 10.0), gravity_at="state")
/// >>> motion = robot.simulate(np.zeros(7), tau=hold, duration=0.5, dt=1e-4, sample_period=0.01, without=["limits"])
/// >>> bool(np.abs(motion.q[-1] - 0.2).max() < np.abs(motion.q[0] - 0.2).max())
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct GravityCompensatedPd {
    robot: Py<Robot>,
    target: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    limits: Option<Vec<f64>>,
    gravity_at: GravityAt,
    implicit_period: Option<f64>,
}

#[pymethods]
impl GravityCompensatedPd {
    #[new]
    #[pyo3(signature = (robot, target, stiffness, damping, *, limits=None, gravity_at="target", implicit_period=None))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        target: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        limits: Option<&Bound<'_, PyAny>>,
        gravity_at: &str,
        implicit_period: Option<f64>,
    ) -> PyResult<Self> {
        let own = robot.get();
        let limits = limits.map(|limits| effort_limits(py, own, limits)).transpose()?;
        let control = Self {
            target: configuration(py, own, target)?,
            stiffness: vector(py, own, "stiffness", stiffness)?,
            damping: vector(py, own, "damping", damping)?,
            limits,
            gravity_at: match gravity_at {
                "target" => GravityAt::Target,
                "state" => GravityAt::State,
                other => {
                    return Err(PyValueError::new_err(format!(
                        "gravity_at = {other:?} must be \"target\" or \"state\""
                    )));
                }
            },
            implicit_period,
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

impl Controls for GravityCompensatedPd {
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        let law = robot_dynamics::simulation::GravityCompensatedPd::new(
            &robot.model,
            &self.target,
            &self.stiffness,
            &self.damping,
        )
        .map_err(exception_of::<ControllerError>)?
        .with_gravity_at(self.gravity_at);
        let law = match &self.limits {
            Some(limits) => law.with_limits(limits),
            None => law,
        };
        let law = match self.implicit_period {
            Some(period) => law.with_implicit_gains(period).map_err(exception_of::<ControllerError>)?,
            None => law,
        };
        Ok(Law { controller: Box::new(law), is_called: false })
    }
}
