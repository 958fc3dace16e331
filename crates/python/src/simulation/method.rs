//! How a motion is integrated: a row of the table by its name, or implicitly with actuators and ground.

use std::collections::HashMap;
use std::ffi::CString;

use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use robot_dynamics::dynamics::Integrator;
use robot_dynamics::{
    Actuation, ContactError, ContactSet, Ground, HeightField, Implicit, MujocoEuler, Pose, SoftConstraints,
    height_field, mesh_corners,
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

/// What the ground is, by the fields of the Python classes.
#[derive(FromPyObject)]
pub(crate) enum GroundFields {
    /// z \[m\], slope \[rad\], friction and restitution.
    Plane(f64, f64, Option<f64>, f64),
    /// Rows, columns, half lengths \[m\], heights \[m\], position \[m\]; friction and restitution.
    Hills(usize, usize, [f64; 2], Vec<f64>, [f64; 3], (Option<f64>, f64)),
    /// `file`: the height fields of the robot's file.
    Named(String),
}

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
fn contacts(py: Python<'_>, robot: &Robot, ground: GroundFields) -> PyResult<ContactSet> {
    let contacts = on_ground(robot, ground).map_err(PyValueError::new_err)?;
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

fn on_ground(robot: &Robot, ground: GroundFields) -> Result<ContactSet, String> {
    let refused = |error: ContactError| error.to_string();
    let contacts_with =
        |planes: &[Ground]| ContactSet::with_meshes(&robot.model, planes, mesh_corners).map_err(refused);
    match ground {
        GroundFields::Plane(z, slope, friction, restitution) => {
            let mut plane = Ground::slope(slope).map_err(refused)?.with_restitution(restitution);
            (plane.offset, plane.friction) = (z * plane.normal[2], friction);
            contacts_with(&[plane])
        }
        GroundFields::Hills(rows, columns, half_size, heights, position, (friction, restitution)) => {
            let mut field = HeightField::new(rows, columns, half_size, heights).map_err(refused)?;
            (field.world_from_field, field.friction) = (Pose::from_translation(position), friction);
            contacts_with(&[])?.with_height_field(&field.with_restitution(restitution)).map_err(refused)
        }
        GroundFields::Named(name) if name == "file" => {
            let contacts = contacts_with(&[])?
                .with_described_height_fields(&robot.model, height_field)
                .map_err(refused)?;
            if contacts.height_field_count() == 0 {
                let left_out = contacts.left_out().join("; ");
                return Err(format!(
                    "ground=\"file\": the file of robot `{}` has no height field that the world carries{}{left_out}",
                    robot.model.name(),
                    if left_out.is_empty() { "" } else { ": " }
                ));
            }
            Ok(contacts)
        }
        GroundFields::Named(name) => Err(format!(
            "ground={name:?}: give a Ground, a HeightField, or \"file\" for the height fields of the robot's file"
        )),
    }
}
