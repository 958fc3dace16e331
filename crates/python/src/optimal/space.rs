//! The space of a problem's states, and states as Python gives them.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use robot_dynamics::control::optimal::{HeldContactStep, StateSpace};
use robot_dynamics::model::Model;

use crate::errors::Class;
use crate::exclusive::Exclusive;
use crate::numbers::{numbers, shaped};
use crate::operand::shown;
use crate::robot::Robot;

/// The states of a problem, and the robot that they belong to.
pub(super) struct Space {
    pub(super) states: StateSpace,
    pub(super) robot: Option<Py<Robot>>,
    held: HeldSteps,
}

/// The steps with held contacts, each with its object of Python: costs read the forces of the node's step.
type HeldSteps = Arc<Exclusive<Vec<(Py<PyAny>, HeldContactStep)>>>;

fn no_steps() -> HeldSteps {
    Arc::new(Exclusive::new(Vec::new()))
}

impl Space {
    /// The space of (q, v) of a robot.
    pub(super) fn of_robot(robot: Py<Robot>, model: Arc<Model>) -> Self {
        Self { states: StateSpace::robot(model), robot: Some(robot), held: no_steps() }
    }

    /// The space of plain numbers.
    pub(super) fn vector(n: usize) -> Self {
        Self { states: StateSpace::vector(n), robot: None, held: no_steps() }
    }

    /// Whether the states are those of this robot.
    pub(super) fn is_of(&self, model: &Model) -> bool {
        self.states.model().is_some_and(|own| own.fingerprint() == model.fingerprint())
    }

    pub(super) fn share(&self, py: Python<'_>) -> Self {
        let robot = self.robot.as_ref().map(|robot| robot.clone_ref(py));
        Self { states: self.states.clone(), robot, held: Arc::clone(&self.held) }
    }

    /// The step of an object, which is built if it is new.
    pub(super) fn held_step(
        &self,
        object: &Bound<'_, PyAny>,
        build: impl FnOnce() -> PyResult<HeldContactStep>,
    ) -> PyResult<HeldContactStep> {
        let py = object.py();
        let known = self.held.lock(py).iter().find(|(own, _)| own.is(object)).map(|(_, step)| step.clone());
        if let Some(step) = known {
            return Ok(step);
        }
        let step = build()?;
        self.held.lock(py).push((object.clone().unbind(), step.clone()));
        Ok(step)
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
