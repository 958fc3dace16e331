//! Bounds of the torques of a motion for a set of robots.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics_certified::{Attained, Interval, Payload, TorqueBounds, Uncertainty, torque_bounds};

use super::bounds::{ends, interval, search};
use crate::errors::{Class, exception};
use crate::numbers::{array, object, record, shaped};
use crate::outcome;
use crate::robot::Robot;

/// Frame, mass, center of mass and radius of gyration.
type PayloadWords<'py> = (Bound<'py, PyAny>, [f64; 2], [[f64; 2]; 3], f64);

/// The factors on masses, by link or of all links; the factor on friction; gravity.
type SetWords = (Vec<(Option<String>, [f64; 2])>, [f64; 2], Option<[[f64; 2]; 3]>);

/// The polynomials of `robot_dynamics.certified.Motion`.
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct PolynomialMotion(robot_dynamics_certified::PolynomialMotion);

#[pymethods]
impl PolynomialMotion {
    /// `kind` is `rest_to_rest` for the quintic polynomial between two points, or `spline`.
    #[new]
    fn new(
        py: Python<'_>,
        kind: &str,
        times: &Bound<'_, PyAny>,
        points: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (shape, numbers) = shaped(py, "points", points, &[usize::MAX, usize::MAX])?;
        let (_, times) = shaped(py, "times", times, &[shape[0]])?;
        let points: Vec<Vec<f64>> =
            (0..shape[0]).map(|k| numbers[k * shape[1]..(k + 1) * shape[1]].to_vec()).collect();
        let motion = match (kind, &*times, &*points) {
            ("rest_to_rest", [_, duration], [start, end]) => {
                robot_dynamics_certified::PolynomialMotion::rest_to_rest(start, end, *duration)
            }
            _ => robot_dynamics_certified::PolynomialMotion::spline(&times, &points),
        };
        motion.map(Self).map_err(exception)
    }

    /// The durations of the pieces (pieces,).
    fn _durations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let durations: Vec<f64> = self.0.pieces().iter().map(|piece| piece.duration).collect();
        array(py, &durations)
    }

    /// The coefficients (pieces, coordinates, 6).
    fn _coefficients<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let pieces = self.0.pieces();
        let numbers: Vec<f64> =
            pieces.iter().flat_map(|piece| &piece.coordinates).flatten().copied().collect();
        outcome::filled(py, &[pieces.len(), self.0.coordinates(), 6], &numbers)
    }

    /// q, v and a at a time from the start of a piece.
    fn _state<'py>(&self, py: Python<'py>, number: usize, time: f64) -> PyResult<[Bound<'py, PyAny>; 3]> {
        if number >= self.0.pieces().len() || !time.is_finite() {
            return Err(Class::State.error(py, format!("the motion has no time {time} in a piece {number}")));
        }
        let [q, v, a] = self.0.state(number, time);
        Ok([array(py, &q)?, array(py, &v)?, array(py, &a)?])
    }
}

#[pymethods]
impl Robot {
    /// See `certify_torques`.
    fn _certify_torques<'py>(
        &self,
        py: Python<'py>,
        motion: &Bound<'py, PolynomialMotion>,
        robots: SetWords,
        payload: Option<PayloadWords<'py>>,
        search_limits: (f64, usize),
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let motion = &motion.get().0;
        let (count, nv) = (motion.coordinates(), self.model.nv());
        if self.model.is_vector_space() && count != nv {
            let message = format!("the motion has {count} coordinates, but {nv} are needed");
            return Err(Class::Shape.error(py, message));
        }
        let robots = set_of(py, self, robots, payload)?;
        let bounds = search(py, search_limits, threads, |options| {
            torque_bounds(&self.model, motion, &robots, options)
        })?;
        let TorqueBounds { proven, attained, parts, is_tight } = bounds.map_err(exception)?;
        let [lower, upper] = ends(py, &[nv], &proven)?;
        let of = |number: fn(&Attained) -> f64| {
            let numbers: Vec<f64> = attained.iter().map(number).collect();
            array(py, &numbers)
        };
        let starts = motion.starts();
        let times: Vec<f64> = parts
            .iter()
            .flat_map(|part| [part.time.lower(), part.time.upper()].map(|time| starts[part.piece] + time))
            .collect();
        let torques: Vec<Interval> = parts.iter().flat_map(|part| &part.torques).copied().collect();
        let [part_lower, part_upper] = ends(py, &[parts.len(), nv], &torques)?;
        record(
            py,
            [
                ("lower", lower),
                ("upper", upper),
                ("least", of(|attained| attained.least)?),
                ("least_time", of(|attained| attained.least_time)?),
                ("greatest", of(|attained| attained.greatest)?),
                ("greatest_time", of(|attained| attained.greatest_time)?),
                ("is_tight", object(py, is_tight)?),
                ("part_times", outcome::filled(py, &[parts.len(), 2], &times)?),
                ("part_lower", part_lower),
                ("part_upper", part_upper),
            ],
        )
    }
}

/// The set of robots of these words.
fn set_of(
    py: Python<'_>,
    robot: &Robot,
    (masses, friction, gravity): SetWords,
    payload: Option<PayloadWords<'_>>,
) -> PyResult<Uncertainty> {
    let model = &robot.model;
    let mut set = Uncertainty::none(model);
    for (link, factor) in masses {
        let factor = interval(py, "the factor of masses", factor)?;
        set = match link {
            None => set.with_mass_factor(factor),
            Some(link) => set.with_mass_factor_of(model, &link, factor),
        }
        .map_err(exception)?;
    }
    set = set.with_friction_factor(interval(py, "friction", friction)?).map_err(exception)?;
    let three = |name: &str, bounds: [[f64; 2]; 3]| -> PyResult<[Interval; 3]> {
        let [x, y, z] = bounds.map(|bounds| interval(py, name, bounds));
        Ok([x?, y?, z?])
    };
    if let Some(gravity) = gravity {
        set = set.with_gravity(three("a component of gravity", gravity)?);
    }
    if let Some((frame, mass, center_of_mass, radius_of_gyration)) = payload {
        let payload = Payload {
            frame: robot.frame_of(&frame)?,
            mass: interval(py, "the mass of the payload", mass)?,
            center_of_mass: three("a coordinate of the center of mass", center_of_mass)?,
            radius_of_gyration,
        };
        set = set.with_payload(model, payload).map_err(exception)?;
    }
    Ok(set)
}
