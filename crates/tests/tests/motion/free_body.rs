//! Helpers of the contact tests: a free body with one shape, and observed runs without torque.

use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    Base, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    Effect, Method, Run, RunOptions, SimulationBuilder, SimulationStepper, StepInfo,
};

/// A body of 1 kg with a moment of inertia about each axis and a shape.
pub(crate) fn body(moment: f64, shape: Shape) -> RobotDescription {
    let mut robot = RobotDescription::new("body");
    robot.base = Base::Floating;
    let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * moment).unwrap();
    robot.links.push(LinkDescription::new("body", mass));
    robot.shapes.push(LinkShape::new("body", ShapeRole::Collision, Pose::IDENTITY, shape));
    robot
}

/// Implicit steps with these contacts.
pub(crate) fn implicit_on(model: &Model, contacts: ContactSet) -> SimulationBuilder<'static> {
    SimulationBuilder::new(model).method(Method::Implicit).contacts(contacts)
}

/// Implicit steps with this ground and no contact between links, or without contact.
pub(crate) fn implicit_over(model: &Model, ground: Option<Ground>) -> SimulationBuilder<'static> {
    match ground {
        Some(ground) => implicit_on(model, ContactSet::new(model, &[ground]).unwrap()),
        None => SimulationBuilder::new(model).method(Method::Implicit).without(Effect::Contacts),
    }
}

/// Steps of h by MuJoCo's law with these contacts.
pub(crate) fn soft_on(model: &Model, contacts: ContactSet, h: f64) -> SimulationBuilder<'static> {
    SimulationBuilder::new(model).method(Method::Mujoco).contacts(contacts).dt(h)
}

/// The stepper of a simulation, for steps from any state.
pub(crate) fn stepper(builder: SimulationBuilder<'_>) -> SimulationStepper {
    builder.build().unwrap().stepper()
}

/// A run with this number of steps of h.
pub(crate) fn run_watched(
    builder: SimulationBuilder<'_>,
    (q, v): (&[f64], &[f64]),
    (h, steps): (f64, usize),
    mut watch: impl FnMut(&StepInfo<'_>),
) -> Run {
    let mut simulation = builder.dt(h).build().unwrap();
    let mut observer = |info: &StepInfo<'_>| {
        watch(info);
        ControlFlow::Continue(())
    };
    simulation.run_steps_from(q, v, steps, RunOptions::new().sample_ends().observer(&mut observer)).unwrap()
}

/// The same with these contacts.
pub(crate) fn run_on(
    model: &Model,
    contacts: ContactSet,
    state: (&[f64], &[f64]),
    steps: (f64, usize),
    watch: impl FnMut(&StepInfo<'_>),
) -> Run {
    run_watched(implicit_on(model, contacts), state, steps, watch)
}
