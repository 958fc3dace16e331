//! The fastest motion along a path within the limits of torque and velocity.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::{
    Collocation, CubicSpline, MotionLimits, TimeOptimal, limit_utilization, time_optimal,
};

use crate::errors::Class;
use crate::numbers::{array, object, record, shaped, vector};
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
        let refused = |error: &dyn std::fmt::Display| Class::Planning.error(py, error);
        let model = &self.model;
        if !model.is_vector_space() {
            return Err(refused(&format!(
                "robot `{}` has quaternions, between which no spline of numbers passes; paths are of robots with nq = nv",
                model.name()
            )));
        }
        let (shape, points) = shaped(py, "waypoints", waypoints, &[usize::MAX, model.nq()])?;
        let rows: Vec<Vec<f64>> = points.chunks_exact(shape[1].max(1)).map(<[f64]>::to_vec).collect();
        let mut limits = MotionLimits::of(model);
        // Bounds of position may be infinite.
        if let Some(lower) = lower {
            (_, limits.lower) = shaped(py, "lower", lower, &[model.nv()])?;
        }
        if let Some(upper) = upper {
            (_, limits.upper) = shaped(py, "upper", upper, &[model.nv()])?;
        }
        let beyond = rows
            .iter()
            .enumerate()
            .find_map(|(index, q)| limits.position_beyond(model, q).map(|(k, value)| (index, k, value)));
        if let Some((index, k, value)) = beyond {
            return Err(refused(&format!(
                "waypoint {index} is beyond the limits of position: coordinate `{}` is at {value}, its limits are {} and {}; \
                 move it inside, or give other limits (lower=, upper=)",
                model.coordinate_names()[k],
                limits.lower[k],
                limits.upper[k]
            )));
        }
        let path = CubicSpline::through(&rows).map_err(|error| refused(&error))?;
        if let Some(torque) = torque {
            limits.torque = vector(py, self, "torque", torque)?;
        }
        if let Some(velocity) = velocity {
            limits.velocity = vector(py, self, "velocity", velocity)?;
        }
        let mut options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals);
        (options.start_speed, options.end_speed) = (start_speed, end_speed);
        options.collocation = if both_ends { Collocation::BothEnds } else { Collocation::Start };
        let timed = py.detach(|| time_optimal(model, &path, &options)).map_err(|error| refused(&error))?;
        let used = limit_utilization(model, &path, &timed, &limits, 4);
        let count = samples.max(2);
        let (mut times, mut tables) = (Vec::with_capacity(count), [const { Vec::new() }; 4]);
        for k in 0..count {
            let t = timed.duration() * k as f64 / (count - 1) as f64;
            let (q, v, a) = timed.state(&path, t);
            let tau = model.inverse_dynamics(&q, &v, &a).map_err(|error| refused(&error))?;
            times.push(t);
            for (table, row) in tables.iter_mut().zip([&q[..], &v, &a, tau.as_slice()]) {
                table.extend_from_slice(row);
            }
        }
        let table = |k: usize| outcome::filled(py, &[count, model.nv()], &tables[k]);
        record(
            py,
            [
                ("duration", object(py, timed.duration())?),
                ("times", array(py, &times)?),
                ("q", table(0)?),
                ("v", table(1)?),
                ("a", table(2)?),
                ("tau", table(3)?),
                ("grid", array(py, timed.grid())?),
                ("squared_speeds", array(py, timed.squared_speeds())?),
                ("saturated", object(py, used.saturated)?),
                ("largest_use", object(py, used.at_grid_points.max(used.in_between))?),
            ],
        )
    }
}
