//! What tests of contact share: a free body of one shape, and runs without torque that are watched.

use std::ops::ControlFlow;

use dynamics::MassProperties;
use multibody::{
    Base, ContactSet, Implicit, LinkDescription, LinkShape, Model, Moment, Pose, RobotDescription, Run,
    Shape, ShapeRole, Simulation, ZeroTorque,
};
use nalgebra::{Matrix3, Vector3};

/// A body of 1 kg with that moment of inertia about each axis and that shape.
pub(crate) fn body(moment: f64, shape: Shape) -> RobotDescription {
    let mut robot = RobotDescription::new("body");
    robot.base = Base::Floating;
    let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * moment).unwrap();
    robot.links.push(LinkDescription::new("body", mass));
    robot.shapes.push(LinkShape::new("body", ShapeRole::Collision, Pose::IDENTITY, shape));
    robot
}

/// A run of so many steps of h.
pub(crate) fn run_watched(
    model: &Model,
    implicit: Implicit,
    (q, v): (&[f64], &[f64]),
    (h, steps): (f64, usize),
    mut watch: impl FnMut(&Moment<'_>),
) -> Run {
    let simulation = Simulation::new(model, implicit, h).with_samples_every(0);
    let observer = |moment: &Moment<'_>| {
        watch(moment);
        ControlFlow::Continue(())
    };
    simulation.run(q, v, steps, &mut ZeroTorque, observer).unwrap()
}

/// The same with these contacts.
pub(crate) fn run_on(
    model: &Model,
    contacts: ContactSet,
    state: (&[f64], &[f64]),
    steps: (f64, usize),
    watch: impl FnMut(&Moment<'_>),
) -> Run {
    run_watched(model, Implicit::new(model).with_contacts(model, contacts), state, steps, watch)
}
