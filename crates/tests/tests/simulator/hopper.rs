//! A body on slides along x and z above the ground, with a sprung leg below it.

use nalgebra::Vector3;
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, PassiveForces, Pose,
    RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Simulation, SimulationBuilder};

/// The hopper, 0.2 m above the ground and moving along x, and its mass \[kg\].
pub(crate) fn hopper() -> (Simulation, f64) {
    let mut robot = RobotDescription::new("hopper");
    robot.links.push(LinkDescription::new("world", None));
    // The rail moves along x only. It has no mass, so that the world carries no weight through it.
    let links = [("rail", None), ("body", Some(5.0)), ("foot", Some(1.0))];
    let joints =
        [("x", "world", [1.0, 0.0, 0.0]), ("z", "rail", [0.0, 0.0, 1.0]), ("leg", "body", [0.0, 0.0, 1.0])];
    for ((link, mass), (name, parent, axis)) in links.into_iter().zip(joints) {
        let point = |mass| MassProperties::point(mass, Vector3::zeros()).expect("a mass");
        robot.links.push(LinkDescription::new(link, mass.map(point)));
        let kind = JointKind::Prismatic { axis };
        robot.joints.push(JointDescription::new(name, kind, parent, link, Pose::IDENTITY));
    }
    let leg = &mut robot.joints[2];
    leg.passive = PassiveForces::default().with_spring(800.0, -0.4).with_damping(20.0).with_friction(2.0);
    leg.limits = Limits::new(-0.5, -0.2);
    let ball = Shape::Sphere { radius: 0.05 };
    robot.shapes.push(LinkShape::new("foot", ShapeRole::Collision, Pose::IDENTITY, ball));
    let model = Model::new(robot).expect("a robot");
    let mut simulation =
        SimulationBuilder::new(&model).ground(Ground::level(0.0)).build().expect("a simulation");
    simulation.reset(&[0.0, 0.65, -0.4], &[0.7, 0.0, 0.0]).expect("a start");
    (simulation, 6.0)
}
