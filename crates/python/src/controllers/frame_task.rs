//! The parts that control laws of a frame share: reference, rows, posture, effort limits.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::algorithms::{SpatialAcceleration, Twist};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::{PoseReference, TaskReference};
use robot_dynamics::model::FrameId;

use super::law::{ReferenceSource, parts};
use crate::constraints::spatial_axes;
use crate::errors::Class;
use crate::numbers::{configuration, halves, numbers, pose_of, several, shaped};
use crate::operand::shown;
use crate::robot::Robot;

/// The directions that are controlled.
pub(super) enum ControlledDirections {
    Position(ReferenceSource<TaskReference>),
    Pose(ReferenceSource<PoseReference>),
}

/// A frame and its task.
pub(super) struct FrameTask {
    pub(super) frame: FrameId,
    pub(super) reference: ControlledDirections,
    pub(super) rows: Option<Vec<SpatialAxis>>,
    pub(super) posture: Option<(Vec<f64>, f64)>,
    pub(super) limits: Option<Vec<f64>>,
}

impl FrameTask {
    /// Reads the arguments of a law.
    pub(super) fn of(
        py: Python<'_>,
        robot: &Robot,
        (frame, reference): (&Bound<'_, PyAny>, &Bound<'_, PyAny>),
        rows: Option<Vec<String>>,
        posture: (Option<&Bound<'_, PyAny>>, f64),
        limits: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let first = if reference.is_callable() { &reference.call1((0.0,))? } else { reference };
        let (place, _) = parts(first)?;
        let (shape, _) = numbers(py, "the reference", &place)?;
        let reference = match shape[..] {
            [4, 4] => ControlledDirections::Pose(ReferenceSource::of(reference, pose_reference)?),
            [3] => ControlledDirections::Position(ReferenceSource::of(reference, task_reference)?),
            _ => {
                let found = shown(&shape);
                let message = format!(
                    "the reference has shape {found}, it must have (3,), a position, or (4, 4), a pose"
                );
                return Err(Class::Shape.error(py, message));
            }
        };
        let (posture, stiffness) = posture;
        let read = |posture| configuration(py, robot, posture).map(|posture| (posture, stiffness));
        Ok(Self {
            frame: robot.frame_of(frame)?,
            reference,
            rows: rows.map(|rows| task_rows(&rows, &shape)).transpose()?,
            posture: posture.map(read).transpose()?,
            limits: limits.map(|limits| effort_limits(py, robot, limits)).transpose()?,
        })
    }
}

/// Effort limits, nv numbers that are not negative.
pub(super) fn effort_limits(py: Python<'_>, robot: &Robot, limits: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let (_, limits) = shaped(py, "limits", limits, &[robot.model.nv()])?;
    match limits.iter().find(|limit| limit.is_nan() || **limit < 0.0) {
        None => Ok(limits),
        Some(bad) => {
            Err(PyValueError::new_err(format!("a limit of effort is {bad}; it must not be negative")))
        }
    }
}

/// A law with the rows, the posture and the effort limits of a task.
macro_rules! with_task {
    ($law:expr, $task:expr) => {{
        let (law, task) = ($law, $task);
        let law = match &task.posture {
            Some((posture, stiffness)) => law
                .with_posture(posture, *stiffness)
                .map_err(exception_of::<robot_dynamics::simulation::ControllerError>)?,
            None => law,
        };
        let law = match &task.limits {
            Some(limits) => law.with_limits(limits),
            None => law,
        };
        match &task.rows {
            Some(rows) => law.with_rows(rows),
            None => law,
        }
    }};
}
pub(super) use with_task;

/// The rows of a reference of this shape by their names.
fn task_rows(names: &[String], shape: &[usize]) -> PyResult<Vec<SpatialAxis>> {
    let rows = spatial_axes(names)?;
    if rows.is_empty() {
        return Err(PyValueError::new_err("rows is empty; name at least one of x, y, z, rx, ry, rz"));
    }
    if let Some(index) = (1..rows.len()).find(|&k| rows[..k].contains(&rows[k])) {
        return Err(PyValueError::new_err(format!("the row {:?} is given twice", names[index])));
    }
    match rows.iter().position(|row| shape == [3] && row.is_turn()) {
        None => Ok(rows),
        Some(index) => Err(PyValueError::new_err(format!(
            "the reference is a position, and the row {:?} is a turn; rows of a position are x, y, z",
            names[index]
        ))),
    }
}

const VELOCITY: &str = "the reference's velocity";
const ACCELERATION: &str = "the reference's acceleration";

pub(super) fn task_reference(given: &Bound<'_, PyAny>) -> PyResult<TaskReference> {
    let (place, rates) = parts(given)?;
    let (velocity, acceleration) = match rates {
        Some((velocity, acceleration)) => {
            (several(VELOCITY, &velocity)?, several(ACCELERATION, &acceleration)?)
        }
        None => ([0.0; 3], [0.0; 3]),
    };
    Ok(TaskReference { position: several("the reference's position", &place)?, velocity, acceleration })
}

pub(crate) fn pose_reference(given: &Bound<'_, PyAny>) -> PyResult<PoseReference> {
    let (place, rates) = parts(given)?;
    let (_, pose) = shaped(given.py(), "the reference's pose", &place, &[4, 4])?;
    let at_rest = PoseReference::at_rest(pose_of(&pose));
    let Some((velocity, acceleration)) = rates else { return Ok(at_rest) };
    let two_vectors = |name, object: &Bound<'_, PyAny>| several(name, object).map(halves);
    let [linear, angular] = two_vectors(VELOCITY, &velocity)?;
    let velocity = Twist { linear, angular };
    let [linear, angular] = two_vectors(ACCELERATION, &acceleration)?;
    Ok(PoseReference { velocity, acceleration: SpatialAcceleration { linear, angular }, ..at_rest })
}
