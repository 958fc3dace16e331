//! The dynamics of a node, from the objects of `robot_dynamics.optimal`.

use std::sync::Arc;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use robot_dynamics::InvalidInput;
use robot_dynamics::constraints::RowFeedback;
use robot_dynamics::control::optimal::{
    ActuationMatrix, DiscreteDynamics, HeldContactStep, ImpactStep, LinearDynamics, SimulationStep,
    SmoothStep,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Integrator;

use super::raised;
use super::space::Space;
use crate::constraint_set::Constraints;
use crate::errors::{Class, exception};
use crate::numbers::{matrix, shaped};
use crate::robot::Robot;
use crate::simulation::stepping::Simulation;

/// The dynamics that an object describes, and the space of its states.
pub(super) fn dynamics_of(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    known: Option<&Space>,
) -> PyResult<(Box<dyn DiscreteDynamics>, Space)> {
    let kind = object.getattr("_kind").and_then(|kind| kind.extract::<String>());
    match kind.as_deref() {
        Ok("smooth_step") => smooth_step(py, object, known),
        Ok("simulation_step") => simulation_step(py, object),
        Ok("held_contact_step") => {
            let space = space_of(object, known)?;
            let step = held_contact_step(py, object, &space)?;
            Ok((Box::new(step), space))
        }
        Ok("impact_step") => impact_step(py, object, known),
        Ok("linear") => linear(py, object),
        _ => Err(PyTypeError::new_err(format!(
            "the dynamics must be a SmoothStep, SimulationStep, HeldContactStep, ImpactStep or LinearDynamics of \
             robot_dynamics.optimal, got {}",
            object.get_type().name()?
        ))),
    }
}

fn smooth_step(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    known: Option<&Space>,
) -> PyResult<(Box<dyn DiscreteDynamics>, Space)> {
    let space = space_of(object, known)?;
    let (_, model) = space.robot(py, "SmoothStep")?;
    let name: String = object.getattr("integrator")?.extract()?;
    let integrator = integrator_of(py, &name)?;
    let (dt, dissipation) = (object.getattr("dt")?.extract()?, object.getattr("dissipation")?.extract()?);
    let step = SmoothStep::new(Arc::clone(model), integrator, dt).map_err(exception)?;
    let step = step.with_dissipation(dissipation);
    let step = with_actuation(py, object, model, step, SmoothStep::with_actuation)?;
    Ok((Box::new(step), space))
}

fn simulation_step(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
) -> PyResult<(Box<dyn DiscreteDynamics>, Space)> {
    let simulation = object.getattr("simulation")?.cast_into::<Simulation>()?;
    let simulation = simulation.borrow();
    let model = Arc::clone(simulation.stepped().shared_model());
    let step = SimulationStep::new(simulation.stepped());
    let word = object.getattr("actuation")?.extract::<String>();
    if word.is_ok_and(|word| word == "actuators") {
        let step = step.with_actuators().map_err(|error| raised(py, error))?;
        return Ok((Box::new(step), Space::of_robot(simulation.robot(py), model)));
    }
    let step = with_actuation(py, object, &model, step, SimulationStep::with_actuation)?;
    Ok((Box::new(step), Space::of_robot(simulation.robot(py), model)))
}

/// The space of an object with a robot: the known one if it belongs to this robot.
fn space_of(object: &Bound<'_, PyAny>, known: Option<&Space>) -> PyResult<Space> {
    let robot = object.getattr("robot")?.cast_into::<Robot>()?.unbind();
    let model = &robot.get().model;
    match known {
        Some(known) if known.is_of(model) => Ok(known.share(object.py())),
        _ => {
            let model = Arc::new(model.clone());
            Ok(Space::of_robot(robot, model))
        }
    }
}

/// The step of a `HeldContactStep`; the steps of one object share their forces.
pub(super) fn held_contact_step(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    space: &Space,
) -> PyResult<HeldContactStep> {
    space.held_step(object, || {
        let (robot, model) = space.robot(py, "HeldContactStep")?;
        let constraints = object.getattr("constraints")?.cast_into::<Constraints>()?;
        let (velocity, position) = (object.getattr("damping")?, object.getattr("stiffness")?);
        let feedback = RowFeedback { position: position.extract()?, velocity: velocity.extract()? };
        let (set, dt) = (constraints.get().of(py, robot)?, object.getattr("dt")?.extract()?);
        let step = HeldContactStep::new(Arc::clone(model), set, feedback, dt).map_err(exception)?;
        with_actuation(py, object, model, step, HeldContactStep::with_actuation)
    })
}

fn impact_step(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    known: Option<&Space>,
) -> PyResult<(Box<dyn DiscreteDynamics>, Space)> {
    let space = space_of(object, known)?;
    let (robot, model) = space.robot(py, "ImpactStep")?;
    let constraints = object.getattr("constraints")?.cast_into::<Constraints>()?;
    let (set, restitution) = (constraints.get().of(py, robot)?, object.getattr("restitution")?.extract()?);
    let step = ImpactStep::new(Arc::clone(model), set, restitution).map_err(|error| raised(py, error))?;
    Ok((Box::new(step), space))
}

fn linear(py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<(Box<dyn DiscreteDynamics>, Space)> {
    let (a, b) = (matrix(py, "a", &object.getattr("a")?)?, matrix(py, "b", &object.getattr("b")?)?);
    let n = a.nrows();
    let dynamics = LinearDynamics::new(a, b).map_err(|error| raised(py, error))?;
    let offset = object.getattr("offset")?;
    let dynamics = if offset.is_none() {
        dynamics
    } else {
        let (_, offset) = shaped(py, "offset", &offset, &[n])?;
        dynamics.with_offset(&offset).map_err(|error| raised(py, error))?
    };
    Ok((Box::new(dynamics), Space::vector(n)))
}

/// An integrator by its name.
fn integrator_of(py: Python<'_>, name: &str) -> PyResult<Integrator> {
    Integrator::from_name(name).map_err(|_| {
        let names: Vec<&str> = Integrator::ALL.iter().map(|row| row.name()).collect();
        let said = format!(
            "there is no integrator {name:?} of a SmoothStep; there are {}. Other methods are dynamics by SimulationStep",
            names.join(", ")
        );
        Class::SimulationInput.error(py, said)
    })
}

/// The step with the actuation of its object.
fn with_actuation<T>(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    model: &Model,
    step: T,
    set: impl FnOnce(T, ActuationMatrix) -> Result<T, InvalidInput>,
) -> PyResult<T> {
    match actuation_of(py, object, model)? {
        Some(actuation) => set(step, actuation).map_err(|error| raised(py, error)),
        None => Ok(step),
    }
}

/// S of an object with `actuation`: `None` for τ = u.
fn actuation_of(
    py: Python<'_>,
    object: &Bound<'_, PyAny>,
    model: &Model,
) -> PyResult<Option<ActuationMatrix>> {
    let given = object.getattr("actuation")?;
    if given.is_none() {
        return Ok(None);
    }
    if let Ok(word) = given.extract::<String>() {
        if word == "motors" {
            return Ok(Some(ActuationMatrix::actuated(model)));
        }
        return Err(PyValueError::new_err(format!(
            "actuation = {word:?} must be None (a control for each coordinate), \"motors\", or a matrix (nv, controls)"
        )));
    }
    let (shape, entries) = shaped(py, "actuation", &given, &[model.nv(), usize::MAX])?;
    ActuationMatrix::new(shape[0], shape[1], &entries).map(Some).map_err(|error| raised(py, error))
}
