//! Lists of pairs of links without contact, or with contact only between the listed pairs.

use robot_dynamics::description::{
    ContactPairDescription, JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose,
    RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Method, SimulationBuilder};
use robot_dynamics::{Classified, ErrorKind};

/// Three balls on slides, one above the other over a plane; each falls on the one below.
fn stack() -> RobotDescription {
    let mut robot = RobotDescription::new("stack");
    robot.links.push(LinkDescription::new("world", None));
    let floor =
        LinkShape::new("world", ShapeRole::Collision, Pose::IDENTITY, Shape::Plane { half_size: [0.0; 2] });
    robot.shapes.push(floor.with_name("floor"));
    for (name, z) in [("low", 0.15), ("middle", 0.4), ("high", 0.65)] {
        let ball = MassProperties::new(1.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity() * 4e-3);
        robot.links.push(LinkDescription::new(name, ball.expect("a ball")));
        let at = Pose::from_translation([0.0, 0.0, z]);
        let kind = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
        robot.joints.push(JointDescription::new(format!("{name}_slide"), kind, "world", name, at));
        let shape = Shape::Sphere { radius: 0.1 };
        let shape = LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, shape);
        robot.shapes.push(shape.with_name(name));
    }
    robot
}

/// The heights of the balls after a second. If each rests on the one below, they are −0.05, −0.1 and −0.15.
fn heights(
    robot: RobotDescription,
    change: impl FnOnce(SimulationBuilder<'static>) -> SimulationBuilder<'static>,
) -> Vec<f64> {
    let model = Model::new(robot).expect("a robot");
    let builder = change(SimulationBuilder::new(&model).method(Method::Implicit));
    let mut simulation = builder.build().expect("a simulation");
    simulation.run_for(1.0).expect("steps");
    simulation.q().to_vec()
}

#[track_caller]
fn assert_rest(found: &[f64], expected: [Option<f64>; 3]) {
    for (found, expected) in found.iter().zip(expected) {
        match expected {
            Some(expected) => assert!((found - expected).abs() < 1e-3, "{found} for {expected}"),
            // Free fall: ½ g t².
            None => assert!((found + 4.905).abs() < 1e-6, "{found} falls freely"),
        }
    }
}

#[test]
fn ignored_pairs_pass_through_each_other() {
    let all = [Some(-0.05), Some(-0.1), Some(-0.15)];
    assert_rest(&heights(stack(), |builder| builder), all);
    let without = heights(stack(), |builder| builder.ignore_contacts([("high", "middle")]));
    // The high ball falls through the middle one onto the low one.
    assert_rest(&without, [Some(-0.05), Some(-0.1), Some(-0.35)]);
    let off_the_floor = heights(stack(), |builder| {
        builder.ignore_contacts([("world", "low"), ("low", "middle"), ("high", "low"), ("middle", "high")])
    });
    assert_rest(&off_the_floor, [None, Some(-0.3), Some(-0.55)]);
}

#[test]
fn pair_of_file_can_be_ignored() {
    let mut robot = stack();
    robot.contact_pairs.push(ContactPairDescription::new(["middle", "low"]));
    let without = heights(robot, |builder| builder.ignore_contacts([("low", "middle")]));
    assert_rest(&without, [Some(-0.05), Some(-0.3), Some(-0.35)]);
}

#[test]
fn only_listed_pairs_and_grounds_touch() {
    let only = heights(stack(), |builder| builder.only_contacts([("middle", "low")]));
    assert_rest(&only, [Some(-0.05), Some(-0.1), Some(-0.55)]);
    let none = heights(stack(), |builder| {
        builder.only_contacts([("middle", "low")]).ignore_contacts([("low", "middle")])
    });
    assert_rest(&none, [Some(-0.05), Some(-0.3), Some(-0.55)]);
}

#[test]
fn unknown_link_names_are_errors() {
    let model = Model::new(stack()).expect("a robot");
    for builder in [
        SimulationBuilder::new(&model).ignore_contacts([("low", "midle")]),
        SimulationBuilder::new(&model).only_contacts([("low", "midle")]),
    ] {
        let error = builder.build().expect_err("no such link");
        assert_eq!(error.kind(), ErrorKind::UnknownName);
        assert!(error.to_string().ends_with("has no link `midle`; did you mean `middle`?"), "{error}");
    }
}
