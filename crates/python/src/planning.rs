//! The fastest motion along a path within limits, and texts of sampled motions.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
use robot_dynamics::control::time_parameterization::ConfigurationSpline;
use robot_dynamics::control::{
    Collocation, CubicSpline, MotionLimits, ParameterizationError, TimeOptimal, TreePath, limit_utilization,
    time_optimal,
};
use robot_dynamics::model::Model;

use crate::errors::{Class, exception, exception_of};
use crate::numbers::{array, shaped};
use crate::outcome;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// See `time_optimal`.
    #[pyo3(signature = (waypoints, limits, intervals, speeds, both_ends, samples))]
    fn _time_optimal<'py>(
        &self,
        py: Python<'py>,
        waypoints: &Bound<'py, PyAny>,
        limits: &Bound<'py, PyDict>,
        intervals: Option<usize>,
        speeds: (f64, f64),
        both_ends: bool,
        samples: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let model = &self.model;
        let rows = waypoint_rows(py, self, waypoints)?;
        let limits = limits_of(py, self, limits)?;
        check_waypoints(py, model, &rows, &limits)?;
        let mut options = match intervals {
            Some(intervals) => TimeOptimal::from_rest_to_rest(limits, intervals.max(1)),
            None => TimeOptimal::new(limits),
        };
        (options.start_speed, options.end_speed) = speeds;
        options.collocation = if both_ends { Collocation::BothEnds } else { Collocation::Start };
        if model.is_vector_space() {
            let path = CubicSpline::through(&rows).map_err(exception_of::<ParameterizationError>)?;
            return fastest(py, model, &path, &options, samples);
        }
        let path =
            ConfigurationSpline::through(model, &rows).map_err(exception_of::<ParameterizationError>)?;
        fastest(py, model, &path, &options, samples)
    }
}

/// The record of the fastest motion along a path.
fn fastest<'py>(
    py: Python<'py>,
    model: &Model,
    path: &(impl TreePath + Sync),
    options: &TimeOptimal,
    samples: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let limits = &options.limits;
    let timed = py.detach(|| time_optimal(model, path, options)).map_err(exception)?;
    let used = limit_utilization(model, path, &timed, limits, 4);
    let trajectory = timed.trajectory(model, path, limits.dissipation, samples.max(2)).map_err(exception)?;
    let record = sampled(py, &trajectory)?;
    record.set_item("duration", timed.duration())?;
    record.set_item("grid", array(py, timed.grid())?)?;
    record.set_item("squared_speeds", array(py, timed.squared_speeds())?)?;
    record.set_item("saturated", used.saturated)?;
    record.set_item("largest_use", used.at_grid_points.max(used.in_between))?;
    let tightest = used.tightest;
    let coordinate = &model.coordinate_names()[tightest.coordinate];
    record.set_item("tightest", (tightest.quantity.to_string(), coordinate, tightest.s))?;
    Ok(record)
}

/// The text of a motion: `format` is `csv`, `json` or `yaml`, the last two of a ROS message.
#[pyfunction]
pub(crate) fn _trajectory_text(
    py: Python<'_>,
    format: &str,
    names: (Vec<String>, Vec<String>),
    times: &Bound<'_, PyAny>,
    states: [Bound<'_, PyAny>; 4],
) -> PyResult<String> {
    let (nq, nv) = (names.0.len(), names.1.len());
    let mut trajectory = JointTrajectory::with_names(names.0, names.1);
    let (shape, times) = shaped(py, "times", times, &[usize::MAX])?;
    let mut tables = [const { Vec::new() }; 4];
    for ((table, given), (name, width)) in
        tables.iter_mut().zip(&states).zip([("q", nq), ("v", nv), ("a", nv), ("tau", nv)])
    {
        (_, *table) = shaped(py, name, given, &[shape[0], width])?;
    }
    for (k, &time) in times.iter().enumerate() {
        let row = |table: usize, width: usize| tables[table][k * width..(k + 1) * width].to_vec();
        let point =
            JointTrajectoryPoint { time, q: row(0, nq), v: row(1, nv), a: row(2, nv), tau: row(3, nv) };
        trajectory.push(point).map_err(exception_of::<ParameterizationError>)?;
    }
    let text = match format {
        "json" => trajectory.to_ros_json(),
        "yaml" => trajectory.to_ros_yaml(),
        _ => Ok(trajectory.to_csv()),
    };
    text.map_err(exception_of::<ParameterizationError>)
}

/// The waypoints (points, nq).
fn waypoint_rows(py: Python<'_>, robot: &Robot, waypoints: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let (shape, points) = shaped(py, "waypoints", waypoints, &[usize::MAX, robot.model.nq()])?;
    Ok(points.chunks_exact(shape[1].max(1)).map(<[f64]>::to_vec).collect())
}

/// The limits by name: those given, or else the robot's.
fn limits_of(py: Python<'_>, robot: &Robot, given: &Bound<'_, PyDict>) -> PyResult<MotionLimits> {
    let mut limits = MotionLimits::of(&robot.model);
    let read = |name: &str| -> PyResult<Option<Vec<f64>>> {
        match given.get_item(name)?.filter(|value| !value.is_none()) {
            Some(value) => Ok(Some(shaped(py, name, &value, &[robot.model.nv()])?.1)),
            None => Ok(None),
        }
    };
    if let Some(torque) = read("torque")? {
        limits.torque_lower = torque.iter().map(|limit| -limit).collect();
        limits.torque_upper = torque;
    }
    for (name, limit) in [
        ("torque_lower", &mut limits.torque_lower),
        ("velocity", &mut limits.velocity),
        ("acceleration", &mut limits.acceleration),
        ("power", &mut limits.power),
        ("lower", &mut limits.lower),
        ("upper", &mut limits.upper),
    ] {
        if let Some(values) = read(name)? {
            *limit = values;
        }
    }
    if let Some(dissipation) = given.get_item("dissipation")? {
        limits.dissipation = dissipation.extract()?;
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

/// One of the vectors of a point.
type Row = fn(&JointTrajectoryPoint) -> &Vec<f64>;

/// The points of a motion as arrays.
fn sampled<'py>(py: Python<'py>, trajectory: &JointTrajectory) -> PyResult<Bound<'py, PyDict>> {
    let points = trajectory.points();
    let times: Vec<f64> = points.iter().map(|point| point.time).collect();
    let record = PyDict::new(py);
    record.set_item("times", array(py, &times)?)?;
    let rows: [(&str, Row); 4] = [
        ("q", |point| &point.q),
        ("v", |point| &point.v),
        ("a", |point| &point.a),
        ("tau", |point| &point.tau),
    ];
    for (name, row) in rows {
        let table: Vec<f64> = points.iter().flat_map(row).copied().collect();
        record.set_item(name, outcome::filled(py, &[points.len(), row(&points[0]).len()], &table)?)?;
    }
    Ok(record)
}
