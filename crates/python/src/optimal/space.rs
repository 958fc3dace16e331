//! The space of a problem's states, and states as Python gives them.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use robot_dynamics::control::optimal::StateSpace;
use robot_dynamics::model::Model;

use crate::errors::Class;
use crate::numbers::{numbers, shaped};
use crate::operand::shown;
use crate::robot::Robot;

/// The states of a problem, and the robot that they belong to.
pub(super) struct Space {
    pub(super) states: StateSpace,
    pub(super) robot: Option<Py<Robot>>,
}

impl Space {
    /// The space of (q, v) of a robot.
    pub(super) fn of_robot(robot: Py<Robot>, model: Arc<Model>) -> Self {
        Self { states: StateSpace::robot(model), robot: Some(robot) }
    }

    /// The space of plain numbers.
    pub(super) fn vector(n: usize) -> Self {
        Self { states: StateSpace::vector(n), robot: None }
    }

    pub(super) fn share(&self, py: Python<'_>) -> Self {
        Self { states: self.states.clone(), robot: self.robot.as_ref().map(|robot| robot.clone_ref(py)) }
    }

    /// The robot and its model; an error that names the part that needs them.
    pub(super) fn robot(&self, py: Python<'_>, part: &str) -> PyResult<(&Robot, &Arc<Model>)> {
        match (&self.robot, self.states.model()) {
            (Some(robot), Some(model)) => Ok((robot.get(), model)),
            _ => Err(Class::Control.error(
                py,
                format!("{part} needs a robot, and the states of this problem are plain numbers"),
            )),
        }
    }

    /// A state: its numbers, or the pair (q, v).
    pub(super) fn state(&self, py: Python<'_>, name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
        if let (Ok(pair), Some(model)) = (given.cast::<PyTuple>(), self.states.model())
            && pair.len() == 2
        {
            let (_, mut x) = shaped(py, &format!("{name}[0]"), &pair.get_item(0)?, &[model.nq()])?;
            let (_, v) = shaped(py, &format!("{name}[1]"), &pair.get_item(1)?, &[model.nv()])?;
            x.extend(v);
            return Ok(x);
        }
        let (shape, x) = numbers(py, name, given)?;
        if shape == [self.states.coordinates()] {
            return Ok(x);
        }
        let pair = if self.robot.is_some() { ", or be a pair (q, v)" } else { "" };
        let (found, asked) = (shown(&shape), shown(&[self.states.coordinates()]));
        Err(Class::Shape.error(py, format!("{name} has shape {found}, it must have {asked}{pair}")))
    }
}
