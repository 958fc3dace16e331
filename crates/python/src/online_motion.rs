//! Online motion from a moving state.

use pyo3::prelude::*;
use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion, Progress};

use crate::errors::exception;
use crate::exclusive::Exclusive;
use crate::numbers::{array, configuration, shaped, vector_or_zeros};
use crate::robot::Robot;

/// The native half of `robot_dynamics.OnlineMotion`.
#[pyclass(subclass, frozen, module = "robot_dynamics._native")]
pub(crate) struct JerkLimitedMotion {
    robot: Py<Robot>,
    own: Exclusive<OnlineMotion>,
}

#[pymethods]
impl JerkLimitedMotion {
    #[new]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        period: f64,
        acceleration: &Bound<'_, PyAny>,
        jerk: &Bound<'_, PyAny>,
        velocity: Option<&Bound<'_, PyAny>>,
        lower: Option<&Bound<'_, PyAny>>,
        upper: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let model = &robot.get().model;
        let read = |name: &str, given: &Bound<'_, PyAny>| {
            shaped(py, name, given, &[model.nv()]).map(|(_, numbers)| numbers)
        };
        let mut limits = OnlineLimits::of(model, read("acceleration", acceleration)?, read("jerk", jerk)?);
        let own = [&mut limits.velocity, &mut limits.lower, &mut limits.upper];
        for (limit, (name, given)) in
            own.into_iter().zip([("velocity", velocity), ("lower", lower), ("upper", upper)])
        {
            if let Some(given) = given {
                *limit = read(name, given)?;
            }
        }
        let motion = OnlineMotion::new(model, limits, period).map_err(exception)?;
        Ok(Self { robot: robot.clone().unbind(), own: Exclusive::new(motion) })
    }

    /// See `set_state`.
    fn _put_state(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        v: Option<&Bound<'_, PyAny>>,
        a: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let [q, v, a] = self.read(py, q, v, a)?;
        self.own.lock(py).set_state(&q, &v, &a).map_err(exception)
    }

    /// See `set_target`.
    fn _put_target(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        v: Option<&Bound<'_, PyAny>>,
        a: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let [q, v, a] = self.read(py, q, v, a)?;
        self.own.lock(py).set_target(&q, &v, &a).map_err(exception)
    }

    /// See `follow_target`.
    fn _follow_target(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        v: Option<&Bound<'_, PyAny>>,
        a: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let [q, v, a] = self.read(py, q, v, a)?;
        self.own.lock(py).follow_target(&q, &v, &a).map_err(exception)
    }

    /// See `plan`.
    fn _remaining(&self, py: Python<'_>) -> PyResult<f64> {
        self.own.lock(py).plan().map_err(exception)
    }

    /// See `step`.
    fn _take_step(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.own.lock(py).step().map_err(exception)? == Progress::Arrived)
    }

    /// The row of the state: 0 for q, 1 for v, 2 for a, 3 for the jerk.
    fn _state_row<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyAny>> {
        let own = self.own.lock(py);
        array(py, [own.q(), own.v(), own.a(), own.jerk()][number.min(3)])
    }
}

impl JerkLimitedMotion {
    fn read(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        v: Option<&Bound<'_, PyAny>>,
        a: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<[Vec<f64>; 3]> {
        let robot = self.robot.get();
        Ok([
            configuration(py, robot, q)?,
            vector_or_zeros(py, robot, "v", v)?,
            vector_or_zeros(py, robot, "a", a)?,
        ])
    }
}
