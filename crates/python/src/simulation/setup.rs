//! The parts of a simulation, by the arguments of the Python half.

use std::collections::HashMap;
use std::ffi::CString;
use std::sync::Arc;

use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use robot_dynamics::constraints::DriftCorrection;
use robot_dynamics::contact::{Ground, HeightField};
use robot_dynamics::description::Pose;
use robot_dynamics::simulation::{
    AdaptiveOptions, CallbackError, ControlTiming, ControllerError, Effect, Method, RunError, Simulation,
    SimulationBuilder, SimulationError,
};

use super::options::{GroundFields, Setup};
use crate::constraints::options_of;
use crate::errors::{Class, exception, exception_of};
use crate::robot::Robot;

impl Setup {
    /// Builds the simulation. If a ground was given, one warning lists the features that the simulation
    /// leaves out.
    pub(crate) fn build(&self, py: Python<'_>, robot: &Robot) -> PyResult<Simulation> {
        let mut builder = robot_dynamics::simulation(&robot.model).dt(self.dt);
        if let Some(name) = &self.integrator {
            builder = builder.method(method_of(py, name)?);
        }
        if self.is_adaptive() {
            let held = |period| ControlTiming::Held { period };
            builder = builder.adaptive(AdaptiveOptions {
                tolerance: self.tolerance.unwrap_or(AdaptiveOptions::DEFAULT_TOLERANCE),
                control: self.control_period.map_or(ControlTiming::Continuous, held),
                ..AdaptiveOptions::default()
            });
            if let Some(flag) = &self.interrupt {
                builder = builder.interrupt(Arc::clone(flag));
            }
        }
        if self.conservative {
            builder = builder.conservative();
        }
        for name in &self.without {
            let effect: Effect =
                name.parse().map_err(|error| PyValueError::new_err(format!("without: {error}")))?;
            builder = builder.without(effect);
        }
        builder = builder.ignore_contacts(self.ignored_pairs.iter().cloned());
        if let Some(pairs) = &self.only_pairs {
            builder = builder.only_contacts(pairs.iter().cloned());
        }
        if let Some(ground) = &self.ground {
            builder = with_ground(robot, builder, ground)?;
        }
        if let Some(constraints) = &self.constraints {
            let set = constraints.get().of(py, robot)?.clone();
            let options = options_of(robot_dynamics::simulation::Integrator::RungeKutta4, self.stabilization);
            let correction = correction_of(&self.correction)?;
            builder = builder.constraints(set).constraint_options(options, correction);
        } else {
            correction_of(&self.correction)?;
        }
        let simulation = py.detach(|| builder.build()).map_err(exception)?;
        self.warn_of_left_out(py, &simulation)?;
        Ok(simulation)
    }

    /// Calls `call` with the simulation. It is set up again only if the arguments differ from those of the
    /// robot's last call.
    pub(crate) fn with_prepared<R>(
        self,
        py: Python<'_>,
        robot: &Robot,
        call: impl FnOnce(&mut Simulation) -> PyResult<R>,
    ) -> PyResult<R> {
        // This does not wait. If another thread has the lock, or a fork has left it locked, a simulation is
        // set up for this call alone.
        let Ok(mut kept) = robot.prepared.try_lock() else { return call(&mut self.build(py, robot)?) };
        let own = match kept.take() {
            Some(mut own) if own.0 == self => {
                let (setup, simulation) = &mut *own;
                setup.warn_of_left_out(py, simulation)?;
                simulation.set_controls(&vec![0.0; simulation.controls().len()]);
                kept.insert(own)
            }
            _ => {
                let simulation = self.build(py, robot)?;
                kept.insert(Box::new((self, simulation)))
            }
        };
        call(&mut own.1)
    }

    /// If a ground was given, one warning lists the features that the simulation leaves out.
    fn warn_of_left_out(&self, py: Python<'_>, simulation: &Simulation) -> PyResult<()> {
        if self.ground.is_some() && !simulation.left_out().is_empty() {
            let left_out =
                simulation.unsupported_features().iter().map(ToString::to_string).collect::<Vec<_>>();
            let said = format!(
                "simulation of `{}` by {} leaves out: {}",
                simulation.model().name(),
                simulation.method(),
                left_out.join("; ")
            );
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(said)?, 2)?;
        }
        Ok(())
    }
}

fn method_of(py: Python<'_>, name: &str) -> PyResult<Method> {
    name.parse().map_err(|_| {
        let names: Vec<&str> = Method::names().collect();
        let said = format!("there is no integrator {name:?}; there are {}", names.join(", "));
        Class::SimulationInput.error(py, said)
    })
}

/// The projection after each step under constraints.
fn correction_of(word: &str) -> PyResult<DriftCorrection> {
    match word {
        "none" => Ok(DriftCorrection::None),
        "velocity" => Ok(DriftCorrection::Velocity),
        "position" => Ok(DriftCorrection::Position { tolerance: SimulationBuilder::EQUALITY_TOLERANCE }),
        _ => Err(PyValueError::new_err(format!(
            "correction = {word:?} must be \"none\", \"velocity\" or \"position\""
        ))),
    }
}

fn with_ground(
    robot: &Robot,
    builder: SimulationBuilder<'static>,
    ground: &GroundFields,
) -> PyResult<SimulationBuilder<'static>> {
    match ground {
        GroundFields::Plane(z, slope, friction, restitution) => {
            let mut plane = Ground::slope(*slope)
                .map_err(exception_of::<SimulationError>)?
                .with_restitution(*restitution);
            (plane.offset, plane.friction) = (z * plane.normal[2], *friction);
            Ok(builder.ground(plane))
        }
        GroundFields::Hills(rows, columns, half_size, heights, position, (friction, restitution)) => {
            let mut field = HeightField::new(*rows, *columns, *half_size, heights.clone())
                .map_err(exception_of::<SimulationError>)?;
            (field.world_from_field, field.friction) = (Pose::from_translation(*position), *friction);
            Ok(builder.height_field(field.with_restitution(*restitution)))
        }
        GroundFields::Named(name) if name == "file" => {
            super::ground::check_file_ground(robot).map_err(PyValueError::new_err)?;
            Ok(builder)
        }
        GroundFields::Named(name) => Err(PyValueError::new_err(super::ground::no_such_ground(name))),
    }
}

/// Sets controls by the actuators' names.
pub(crate) fn controls_of(
    robot: &Robot,
    simulation: &Simulation,
    given: HashMap<String, f64>,
    values: &mut [f64],
) -> PyResult<()> {
    let names: Vec<&str> = simulation.control_names().collect();
    for (name, value) in given {
        let Some(index) = names.iter().position(|own| *own == name) else {
            let known = if names.is_empty() {
                "no actuators act in this simulation".into()
            } else {
                format!("it has {}", names.join(", "))
            };
            return Err(PyValueError::new_err(format!(
                "robot `{}` has no actuator {name:?}; {known}",
                robot.model.name()
            )));
        };
        values[index] = value;
    }
    Ok(())
}

/// The exception of a step that failed. Its cause is the exception that Python itself had raised, if any.
pub(super) fn failed_step(py: Python<'_>, error: &RunError) -> PyErr {
    let raised = Class::of(error).error(py, error);
    if let RunError::Controller { source: ControllerError::Callback(callback), .. } = error
        && let Some(own) = CallbackError::downcast_ref::<PyErr>(callback)
    {
        raised.set_cause(py, Some(own.clone_ref(py)));
    }
    raised
}
