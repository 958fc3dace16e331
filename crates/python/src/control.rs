//! Control: inverse kinematics, operational space, the linear-quadratic regulator.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::{FrameTarget, InverseKinematicsOptions, inverse_kinematics, operational_space};

use crate::constraints::spatial_axes;
use crate::errors::{Class, exception};
use crate::numbers::{
    array, array_of, configuration, matrix, numbers, object, pose_of, record, vector_or_zeros,
};
use crate::operand::shown;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// See `inverse_kinematics`.
    #[pyo3(signature = (frame, target, start, *, position_tolerance, angle_tolerance, max_iterations, max_restarts, seed))]
    fn _inverse_kinematics<'py>(
        &self,
        py: Python<'py>,
        frame: &Bound<'py, PyAny>,
        target: &Bound<'py, PyAny>,
        start: Option<&Bound<'py, PyAny>>,
        position_tolerance: f64,
        angle_tolerance: f64,
        max_iterations: usize,
        max_restarts: usize,
        seed: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let frame = self.frame_of(frame)?;
        let (shape, goal) = numbers(py, "target", target)?;
        let target: FrameTarget = match shape[..] {
            [3] => [goal[0], goal[1], goal[2]].into(),
            [4, 4] => pose_of(&goal).into(),
            _ => {
                let found = shown(&shape);
                let message =
                    format!("target has shape {found}, it must have (3,), a position, or (4, 4), a pose");
                return Err(Class::Shape.error(py, message));
            }
        };
        let start = match start {
            Some(start) => configuration(py, self, start)?,
            None => robot_dynamics::model::neutral(&self.model),
        };
        let options = InverseKinematicsOptions::default()
            .with_tolerances(position_tolerance, angle_tolerance)
            .with_iterations(max_iterations)
            .with_restarts(max_restarts, seed);
        let model = &self.model;
        let solved = py.detach(|| {
            self.with_workspace(|workspace| {
                inverse_kinematics(model, workspace, frame, target, &start, &options)
            })
        });
        let solution = solved.map_err(exception)?;
        record(
            py,
            [
                ("q", array(py, &solution.q)?),
                ("position_error", object(py, solution.position_error)?),
                ("angle_error", object(py, solution.angle_error)?),
                ("iterations", object(py, solution.iterations)?),
                ("restarts", object(py, solution.restarts)?),
            ],
        )
    }

    /// See `operational_space`.
    fn _operational_space<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        frame: &Bound<'py, PyAny>,
        rows: Vec<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (frame, rows) = (self.frame_of(frame)?, spatial_axes(&rows)?);
        let (q, v) = (configuration(py, self, q)?, vector_or_zeros(py, self, "v", v)?);
        let space = self
            .with_workspace(|workspace| operational_space(&self.model, workspace, &q, &v, frame, &rows))
            .map_err(exception)?;
        record(
            py,
            [
                ("inertia", array_of(py, &space.inertia)?),
                ("jacobian", array_of(py, &space.jacobian)?),
                ("consistent_inverse", array_of(py, &space.consistent_inverse)?),
                ("bias_acceleration", array(py, space.bias_acceleration.as_slice())?),
                ("bias_force", array(py, space.bias_force.as_slice())?),
            ],
        )
    }
}

/// The gain K of u = −K x that minimises Σ xᵀQ x + uᵀR u along xₖ₊₁ = A xₖ + B uₖ, and its cost; see
/// `robot_dynamics.dlqr`.
#[pyfunction]
pub(crate) fn dlqr<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    q: &Bound<'py, PyAny>,
    r: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (matrix(py, "A", a)?, matrix(py, "B", b)?);
    let (q, r) = (matrix(py, "Q", q)?, matrix(py, "R", r)?);
    let found = robot_dynamics::control::dlqr(&a, &b, &q, &r).map_err(exception)?;
    record(
        py,
        [
            ("gain", array_of(py, &found.gain)?),
            ("cost", array_of(py, &found.cost)?),
            ("spectral_radius", object(py, found.spectral_radius)?),
        ],
    )
}
