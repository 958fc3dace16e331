//! How a motion is integrated: a row of the table by its name, or implicitly with actuators.

use std::collections::HashMap;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::dynamics::Integrator;
use robot_dynamics::{Actuation, Implicit};

use crate::errors::Class;
use crate::numbers;
use crate::robot::Robot;

/// What takes the steps.
pub(super) enum Method {
    Row(Integrator),
    Implicit(Box<Implicit>),
}

impl Method {
    /// A row by its name, or `implicit`; controls by the actuators' names.
    pub(super) fn of(
        py: Python<'_>,
        robot: &Robot,
        name: &str,
        stops: bool,
        controls: Option<HashMap<String, f64>>,
    ) -> PyResult<Self> {
        if name != "implicit" {
            return match controls {
                None => numbers::integrator(py, name).map(Self::Row),
                Some(_) => Err(PyValueError::new_err(format!(
                    "controls go with integrator='implicit', as actuators follow the state within a step; {name:?} holds \
                     its forces"
                ))),
            };
        }
        let implicit = Implicit::new(&robot.model);
        let implicit = if stops { implicit } else { implicit.without_stops() };
        let actuation = Actuation::new(&robot.model).map_err(|error| Class::Load.error(py, error))?;
        let Some(given) = controls else {
            return Ok(Self::Implicit(Box::new(
                implicit.with_actuation(&actuation.without_actuators(), &[]),
            )));
        };
        let names: Vec<&str> = actuation.control_names().collect();
        let mut values = vec![0.0; names.len()];
        for (name, value) in given {
            let Some(index) = names.iter().position(|own| *own == name) else {
                return Err(PyValueError::new_err(format!(
                    "robot `{}` has no actuator {name:?}; it has {}",
                    robot.model.name(),
                    if names.is_empty() { "none".into() } else { names.join(", ") }
                )));
            };
            values[index] = value;
        }
        Ok(Self::Implicit(Box::new(implicit.with_actuation(&actuation, &values))))
    }
}
