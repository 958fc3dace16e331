//! The fastest motion along a path within the limits of torque and velocity.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::{
    Collocation, CubicSpline, MotionLimits, ParameterizationError, TimeOptimal, TimedPath, limit_utilization,
    time_optimal,
};
use robot_dynamics::model::Model;

use crate::errors::{Class, exception, exception_of};
use crate::numbers::{array, shaped, vector};
use crate::outcome;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// See `time_optimal`.
    #[pyo3(signature = (waypoints, *, torque, velocity, lower, upper, intervals, start_speed, end_speed, both_ends, samples))]
    fn _time_optimal<'py>(
        &self,
        py: Python<'py>,
        waypoints: &Bound<'py, PyAny>,
        torque: Option<&Bound<'py, PyAny>>,
        velocity: Option<&Bound<'py, PyAny>>,
        lower: Option<&Bound<'py, PyAny>>,
        upper: Option<&Bound<'py, PyAny>>,
        intervals: usize,
        start_speed: f64,
        end_speed: f64,
        both_ends: bool,
        samples: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let model = &self.model;
        let rows = waypoint_rows(py, self, waypoints)?;
        let limits = limits_of(py, self, [torque, velocity, lower, upper])?;
        check_waypoints(py, model, &rows, &limits)?;
        let path = CubicSpline::through(&rows).map_err(exception_of::<ParameterizationError>)?;
        let mut options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals);
        (options.start_speed, options.end_speed) = (start_speed, end_speed);
        options.collocation = if both_ends { Collocation::BothEnds } else { Collocation::Start };
        let timed = py.detach(|| time_optimal(model, &path, &options)).map_err(exception)?;
        let used = limit_utilization(model, &path, &timed, &limits, 4);
        let record = sampled(py, model, &path, &timed, samples.max(2))?;
        record.set_item("duration", timed.duration())?;
        record.set_item("grid", array(py, timed.grid())?)?;
        record.set_item("squared_speeds", array(py, timed.squared_speeds())?)?;
        record.set_item("saturated", used.saturated)?;
        record.set_item("largest_use", used.at_grid_points.max(used.in_between))?;
        Ok(record)
    }
}

/// The waypoints (points, nq) of a robot whose configurations are vectors.
fn waypoint_rows(py: Python<'_>, robot: &Robot, waypoints: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let model = &robot.model;
    if !model.is_vector_space() {
        let message = format!(
            "robot `{}` has quaternions, between which no spline of numbers passes; paths are of robots with nq = nv",
            model.name()
        );
        return Err(Class::Planning.error(py, message));
    }
    let (shape, points) = shaped(py, "waypoints", waypoints, &[usize::MAX, model.nq()])?;
    Ok(points.chunks_exact(shape[1].max(1)).map(<[f64]>::to_vec).collect())
}

/// The limits of torque, velocity and lower and upper position: those given, or else the robot's. Limits of
/// position may be infinite.
fn limits_of(
    py: Python<'_>,
    robot: &Robot,
    [torque, velocity, lower, upper]: [Option<&Bound<'_, PyAny>>; 4],
) -> PyResult<MotionLimits> {
    let mut limits = MotionLimits::of(&robot.model);
    let nv = robot.model.nv();
    if let Some(lower) = lower {
        (_, limits.lower) = shaped(py, "lower", lower, &[nv])?;
    }
    if let Some(upper) = upper {
        (_, limits.upper) = shaped(py, "upper", upper, &[nv])?;
    }
    if let Some(torque) = torque {
        limits.torque = vector(py, robot, "torque", torque)?;
    }
    if let Some(velocity) = velocity {
        limits.velocity = vector(py, robot, "velocity", velocity)?;
    }
    Ok(limits)
}

/// Refuses a waypoint beyond the limits of position.
fn check_waypoints(py: Python<'_>, model: &Model, rows: &[Vec<f64>], limits: &MotionLimits) -> PyResult<()> {
    let beyond = rows
        .iter()
        .enumerate()
        .find_map(|(index, q)| limits.position_beyond(model, q).map(|(k, value)| (index, k, value)));
    let Some((index, k, value)) = beyond else { return Ok(()) };
    let message = format!(
        "waypoint {index} is beyond the limits of position: coordinate `{}` is at {value}, its limits are {} and {}; \
         move it inside, or give other limits (lower=, upper=)",
        model.coordinate_names()[k],
        limits.lower[k],
        limits.upper[k]
    );
    Err(Class::Planning.error(py, message))
}

/// The motion at equally spaced times, from the start to the end.
fn sampled<'py>(
    py: Python<'py>,
    model: &Model,
    path: &CubicSpline,
    timed: &TimedPath,
    count: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (mut times, mut tables) = (Vec::with_capacity(count), [const { Vec::new() }; 4]);
    for k in 0..count {
        let t = timed.duration() * k as f64 / (count - 1) as f64;
        let (q, v, a) = timed.state(path, t);
        let tau = model.inverse_dynamics(&q, &v, &a).map_err(|error| Class::Planning.error(py, error))?;
        times.push(t);
        for (table, row) in tables.iter_mut().zip([&q[..], &v, &a, tau.as_slice()]) {
            table.extend_from_slice(row);
        }
    }
    let record = PyDict::new(py);
    record.set_item("times", array(py, &times)?)?;
    for (name, table) in ["q", "v", "a", "tau"].into_iter().zip(&tables) {
        record.set_item(name, outcome::filled(py, &[count, model.nv()], table)?)?;
    }
    Ok(record)
}
