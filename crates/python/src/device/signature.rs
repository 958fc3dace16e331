//! The tables of a function, with the shapes that arrays have in Python.

use pyo3::prelude::*;
use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::ContactStep;
use robot_dynamics_generate::{Function, Table};

use crate::errors::exception;
use crate::robot::Robot;

/// Name and shape of a table, without the axis of the batch.
type NamedShape = (String, Vec<usize>);

/// The tables that a function reads and writes: name and shape of each.
#[pyfunction]
#[pyo3(signature = (robot, name))]
pub(crate) fn _device_signature(
    robot: &Bound<'_, Robot>,
    name: &str,
) -> PyResult<(Vec<NamedShape>, Vec<NamedShape>)> {
    let function: Function = name.parse().map_err(exception)?;
    let (model, other) = (&robot.get().model, reference()?);
    let shapes = |tables: Vec<Table>, reference: Vec<Table>| -> Vec<NamedShape> {
        tables
            .iter()
            .zip(&reference)
            .map(|(table, other)| (table.name.to_owned(), shape(table, other)))
            .collect()
    };
    let reads = shapes(function.reads(model), function.reads(&other));
    Ok((reads, shapes(function.writes(model), function.writes(&other))))
}

/// A shape with as many axes as the table has for a robot with two joints: a matrix of one number is a
/// matrix, and an energy is a number.
fn shape(table: &Table, other: &Table) -> Vec<usize> {
    match (other.rows, other.columns) {
        (1, 1) => vec![],
        (_, 1) => vec![table.rows],
        _ => vec![table.rows, table.columns],
    }
}

/// A robot with two joints.
fn reference() -> PyResult<Model> {
    let mut robot = pendulum(1.0, 1.0);
    robot.links.push(LinkDescription::new("second", robot.links[1].mass_properties));
    let (kind, parent) = (JointKind::Revolute { axis: [0.0, 0.0, 1.0] }, robot.links[1].name.clone());
    robot.joints.push(JointDescription::new("second", kind, parent, "second", Pose::IDENTITY));
    Model::new(robot).map_err(exception)
}

/// The link of each contact point of a step with contact, in the order of its multipliers.
#[pyfunction]
pub(crate) fn _contact_links(robot: &Bound<'_, Robot>) -> PyResult<Vec<String>> {
    Ok(ContactStep::new(&robot.get().model, 1).map_err(exception)?.links().to_vec())
}
