//! Residuals and costs, from the objects of `robot_dynamics.optimal`.

use std::sync::Arc;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::control::optimal::{
    Activation, CenterOfMassResidual, ContactForceResidual, ControlResidual, Cost, FramePlacementResidual,
    FrameRotationResidual, FrameTranslationResidual, FrameVelocityResidual, LeastSquares, Residual,
    StateResidual, Weights,
};
use robot_dynamics::model::{FrameId, Model};

use super::dynamics::held_contact_step;
use super::function::FunctionResidual;
use super::raised;
use super::space::Space;
use crate::errors::Class;
use crate::numbers::{numbers, pose_of, several, shaped};
use crate::row::reference_frame_of;

/// The cost of a list of `LeastSquares` terms at a node with this number of controls.
pub(super) fn cost_of(
    py: Python<'_>,
    space: &Space,
    controls: usize,
    terms: &[Bound<'_, PyAny>],
) -> PyResult<Cost> {
    let mut cost = Cost::new();
    for term in terms {
        let Ok(residual) = term.getattr("residual") else {
            let found = term.get_type().name()?;
            let message =
                format!("a term of a cost must be a LeastSquares of robot_dynamics.optimal, got {found}");
            return Err(PyTypeError::new_err(message));
        };
        let residual = residual_of(py, space, controls, &residual)?;
        let dimension = residual.dimension();
        let weights = weights_of(py, &term.getattr("weights")?)?;
        let least_squares = LeastSquares::new(residual, weights).map_err(|error| raised(py, error))?;
        let bound = |name: &str, missing: f64| {
            let given = term.getattr(name)?;
            entries_of(py, name, &given, dimension, missing)
        };
        let (lower, upper) = (term.getattr("lower")?, term.getattr("upper")?);
        let least_squares = if lower.is_none() && upper.is_none() {
            least_squares
        } else {
            let (lower, upper) = (bound("lower", f64::NEG_INFINITY)?, bound("upper", f64::INFINITY)?);
            let barrier = Activation::QuadraticBarrier { lower, upper };
            least_squares.with_activation(barrier).map_err(|error| raised(py, error))?
        };
        cost.add_term(least_squares);
    }
    Ok(cost)
}

/// One number for each entry of a residual: those given, one number for all, or `missing`.
pub(super) fn entries_of(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
    dimension: usize,
    missing: f64,
) -> PyResult<Vec<f64>> {
    if given.is_none() {
        return Ok(vec![missing; dimension]);
    }
    let (shape, entries) = numbers(py, name, given)?;
    if shape.is_empty() {
        return Ok(vec![given.extract()?; dimension]);
    }
    shaped(py, name, given, &[dimension]).map(|_| entries)
}

fn weights_of(py: Python<'_>, given: &Bound<'_, PyAny>) -> PyResult<Weights> {
    if let Ok(weight) = given.extract::<f64>() {
        return Ok(weight.into());
    }
    let (_, weights) = shaped(py, "weights", given, &[usize::MAX])?;
    Ok(weights.into())
}

/// The residual that an object describes.
pub(super) fn residual_of(
    py: Python<'_>,
    space: &Space,
    controls: usize,
    object: &Bound<'_, PyAny>,
) -> PyResult<Box<dyn Residual>> {
    let kind = object.getattr("_kind").and_then(|kind| kind.extract::<String>());
    let target = || object.getattr("target");
    let refused = |error| raised(py, error);
    Ok(match kind.as_deref() {
        Ok("state") => {
            let state = space.state(py, "the target state", &target()?)?;
            Box::new(StateResidual::new(&space.states, &state).map_err(refused)?)
        }
        Ok("control") => {
            let target = entries_of(py, "the target controls", &target()?, controls, 0.0)?;
            Box::new(ControlResidual::new(&target).map_err(refused)?)
        }
        Ok("frame_translation") => {
            let (model, frame) = frame_of(py, space, object)?;
            let target = several("the target position", &target()?)?;
            Box::new(FrameTranslationResidual::new(model, frame, target).map_err(refused)?)
        }
        Ok("frame_rotation") => {
            let (model, frame) = frame_of(py, space, object)?;
            let (_, m) = shaped(py, "the target rotation", &target()?, &[3, 3])?;
            let rotation = [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]];
            Box::new(FrameRotationResidual::new(model, frame, rotation).map_err(refused)?)
        }
        Ok("frame_placement") => {
            let (model, frame) = frame_of(py, space, object)?;
            let (_, pose) = shaped(py, "the target pose", &target()?, &[4, 4])?;
            Box::new(FramePlacementResidual::new(model, frame, pose_of(&pose)).map_err(refused)?)
        }
        Ok("frame_velocity") => {
            let (model, frame) = frame_of(py, space, object)?;
            let name: String = object.getattr("reference_frame")?.extract()?;
            let axes: ReferenceFrame = reference_frame_of("reference_frame", &name)?;
            let target = target()?;
            let target = if target.is_none() { [0.0; 6] } else { several("the target velocity", &target)? };
            Box::new(FrameVelocityResidual::new(model, frame, axes, target).map_err(refused)?)
        }
        Ok("center_of_mass") => {
            let (_, model) = space.robot(py, "CenterOfMassResidual")?;
            let target = several("the target position", &target()?)?;
            Box::new(CenterOfMassResidual::new(Arc::clone(model), target).map_err(refused)?)
        }
        Ok("contact_force") => Box::new(contact_force(py, space, object)?),
        Ok("friction_pyramid") => Box::new(friction_pyramid(py, space, object)?),
        Ok("function") => Box::new(function_of(space, object)?),
        _ => {
            let found = object.get_type().name()?;
            let message = format!("a residual must be one of robot_dynamics.optimal, got {found}");
            return Err(PyTypeError::new_err(message));
        }
    })
}

fn contact_force(py: Python<'_>, space: &Space, object: &Bound<'_, PyAny>) -> PyResult<ContactForceResidual> {
    let step = held_contact_step(py, &object.getattr("step")?, space)?;
    let rows = step.constraints().len();
    let target = entries_of(py, "the target forces", &object.getattr("target")?, rows, 0.0)?;
    ContactForceResidual::tracking(&step, &target).map_err(|error| raised(py, error))
}

fn friction_pyramid(
    py: Python<'_>,
    space: &Space,
    object: &Bound<'_, PyAny>,
) -> PyResult<ContactForceResidual> {
    let step = held_contact_step(py, &object.getattr("step")?, space)?;
    let (contact, friction): (String, f64) =
        (object.getattr("contact")?.extract()?, object.getattr("friction")?.extract()?);
    let names = step.constraints().row_names();
    let row = |axis: &str| {
        let name = format!("{contact}.{axis}");
        names.iter().position(|own| *own == name).ok_or_else(|| {
            let message = format!("there is no row {name:?}; the step holds {}", names.join(", "));
            Class::Constraint.error(py, message)
        })
    };
    let rows = [row("x")?, row("y")?, row("z")?];
    ContactForceResidual::friction_pyramid(&step, rows, friction).map_err(|error| raised(py, error))
}

fn function_of(space: &Space, object: &Bound<'_, PyAny>) -> PyResult<FunctionResidual> {
    let derivatives = object.getattr("derivatives")?;
    Ok(FunctionResidual {
        space: space.states.clone(),
        dimension: object.getattr("dimension")?.extract()?,
        function: Arc::new(object.getattr("function")?.unbind()),
        derivatives: (!derivatives.is_none()).then(|| Arc::new(derivatives.unbind())),
    })
}

fn frame_of(py: Python<'_>, space: &Space, object: &Bound<'_, PyAny>) -> PyResult<(Arc<Model>, FrameId)> {
    let (robot, model) = space.robot(py, &object.get_type().name()?.to_string())?;
    let frame = robot.frame_of(&object.getattr("frame")?)?;
    Ok((Arc::clone(model), frame))
}
