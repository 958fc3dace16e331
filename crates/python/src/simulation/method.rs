//! How a motion is integrated: a row of the table by its name, or implicitly with actuators and ground.

use std::collections::HashMap;
use std::ffi::CString;

use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use robot_dynamics::dynamics::Integrator;
use robot_dynamics::{
    Actuation, ContactError, ContactSet, Ground, Implicit, MujocoEuler, SoftConstraints, mesh_corners,
};

use super::adaptive::Adaptive;
use crate::errors::Class;
use crate::numbers;
use crate::robot::Robot;

/// What takes the steps.
pub(crate) enum Method {
    Row(Integrator),
    /// With the links that can touch the ground.
    Implicit(Box<Implicit>, Vec<String>),
    Adaptive(Adaptive),
    /// MuJoCo's step under its law of constraints, with the links that can touch the ground.
    Mujoco(Box<MujocoEuler>, Vec<String>),
}

/// z \[m\], slope \[rad\], friction and restitution of the ground.
pub(crate) type GroundFields = (f64, f64, Option<f64>, f64);

impl Method {
    /// A row by its name, `implicit`, `mujoco` or `adaptive`; controls by the actuators' names.
    pub(crate) fn of(
        py: Python<'_>,
        robot: &Robot,
        name: &str,
        stops: bool,
        controls: Option<HashMap<String, f64>>,
        ground: Option<GroundFields>,
        (tolerance, control_period): (Option<f64>, Option<f64>),
        step: f64,
    ) -> PyResult<Self> {
        let touches = matches!(name, "implicit" | "mujoco");
        if name != "adaptive" && (tolerance.is_some() || control_period.is_some()) {
            return Err(PyValueError::new_err(format!(
                "tolerance and control_period go with integrator='adaptive'; {name:?} takes steps of one length"
            )));
        }
        if !touches && ground.is_some() {
            return Err(PyValueError::new_err(format!(
                "ground goes with integrator='implicit' or 'mujoco'; {name:?} knows no contact"
            )));
        }
        if !touches {
            return match controls {
                None if name == "adaptive" => {
                    Ok(Self::Adaptive(Adaptive { tolerance: tolerance.unwrap_or(1e-9), control_period }))
                }
                None => numbers::integrator(py, name).map(Self::Row),
                Some(_) => Err(PyValueError::new_err(format!(
                    "controls go with integrator='implicit' or 'mujoco', as actuators follow the state within a step; {name:?} holds \
                     its forces"
                ))),
            };
        }
        let actuation = Actuation::new(&robot.model).map_err(|error| Class::Load.error(py, error))?;
        let values = match controls {
            Some(given) => Some(control_values(robot, &actuation, given)?),
            None => None,
        };
        let model = &robot.model;
        if name == "mujoco" {
            if !stops {
                return Err(PyValueError::new_err(
                    "stops=False goes with integrator='implicit'; MuJoCo's law holds the joints' limits",
                ));
            }
            let law =
                SoftConstraints::new(model, step).map_err(|error| Class::Simulation.error(py, error))?;
            let (law, links) = match ground {
                Some(ground) => {
                    let contacts = contacts(py, robot, ground)?;
                    let links = contacts.links().to_vec();
                    (law.with_ground(model, contacts), links)
                }
                None => (law, Vec::new()),
            };
            let stepper = MujocoEuler::new(model, law);
            let stepper = match values {
                Some(values) => stepper.with_actuation(&actuation, &values),
                None => stepper.with_actuation(&actuation.without_actuators(), &[]),
            };
            return Ok(Self::Mujoco(Box::new(stepper), links));
        }
        let implicit = Implicit::new(model);
        let implicit = if stops { implicit } else { implicit.without_stops() };
        let (implicit, links) = match ground {
            Some(ground) => {
                let contacts = contacts(py, robot, ground)?;
                let links = contacts.links().to_vec();
                (implicit.with_contacts(&robot.model, contacts), links)
            }
            None => (implicit, Vec::new()),
        };
        let implicit = match values {
            Some(values) => implicit.with_actuation(&actuation, &values),
            None => implicit.with_actuation(&actuation.without_actuators(), &[]),
        };
        Ok(Self::Implicit(Box::new(implicit), links))
    }
}

/// The controls in the actuators' order; 0 where none is named.
fn control_values(robot: &Robot, actuation: &Actuation, given: HashMap<String, f64>) -> PyResult<Vec<f64>> {
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
    Ok(values)
}

/// The robot's shapes on that ground.
fn contacts(
    py: Python<'_>,
    robot: &Robot,
    (z, slope, friction, restitution): GroundFields,
) -> PyResult<ContactSet> {
    let refused = |error: ContactError| PyValueError::new_err(error.to_string());
    let mut ground = Ground::slope(slope).map_err(refused)?.with_restitution(restitution);
    (ground.offset, ground.friction) = (z * ground.normal[2], friction);
    let contacts = ContactSet::with_meshes(&robot.model, &[ground], mesh_corners).map_err(refused)?;
    if !contacts.has_shapes() {
        let left_out = contacts.left_out().join("; ");
        return Err(PyValueError::new_err(format!(
            "robot `{}` has no collision shape that can touch the ground{}{left_out}",
            robot.model.name(),
            if left_out.is_empty() { "" } else { ": " }
        )));
    }
    if !contacts.left_out().is_empty() {
        let said = format!("shapes that do not touch the ground: {}", contacts.left_out().join("; "));
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(said)?, 2)?;
    }
    Ok(contacts)
}
