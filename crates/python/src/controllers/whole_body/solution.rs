//! Solutions for the Python half.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::whole_body::{ContactId, Limit, WholeBodySolution};
use robot_dynamics::model::Model;

use crate::numbers::{array, object, record};

/// A solution as a record.
pub(super) fn solution_of<'py>(
    py: Python<'py>,
    model: &Model,
    solution: &WholeBodySolution,
) -> PyResult<Bound<'py, PyDict>> {
    let mut forces = Vec::with_capacity(solution.forces.len());
    for point in &solution.forces {
        let (position, force) = (array(py, &point.position)?, array(py, &point.force)?);
        forces.push((point.contact.index(), point.point, position, force));
    }
    let names = model.coordinate_names();
    let limits = solution.active_limits.iter().map(|active| {
        let (kind, coordinate, contact, point) = match active.limit {
            Limit::Torque { dof } => ("torque", names.get(dof), None, None),
            Limit::Acceleration { dof } => ("acceleration", names.get(dof), None, None),
            Limit::NormalForce { contact, point } => ("normal_force", None, Some(contact), Some(point)),
            Limit::Friction { contact, point, .. } => ("friction", None, Some(contact), Some(point)),
            _ => ("other", None, None, None),
        };
        let contact = contact.map(ContactId::index);
        (kind, coordinate.cloned(), contact, point, active.is_upper, active.multiplier)
    });
    record(
        py,
        [
            ("torque", array(py, &solution.torque)?),
            ("acceleration", array(py, &solution.acceleration)?),
            ("forces", object(py, forces)?),
            ("active_limits", object(py, limits.collect::<Vec<_>>())?),
            ("task_errors", array(py, &solution.task_errors)?),
            ("steps", object(py, solution.steps)?),
        ],
    )
}
