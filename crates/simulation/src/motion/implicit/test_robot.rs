//! A robot for unit tests of the steps.

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_description::{
    JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription,
    Shape, ShapeRole,
};

/// Two rods with their masses at the middle, each joint with a stop at 0.
pub(super) fn arm() -> Model {
    let mut robot = RobotDescription::new("arm");
    robot.links.push(LinkDescription::new("base", None));
    let joints = [
        ("shoulder", "base", "upper arm", 0.0, Limits::new(-3.0, 0.0)),
        ("elbow", "upper arm", "forearm", 1.0, Limits::new(0.0, 3.0)),
    ];
    for (name, parent, link, x, limits) in joints {
        let mass = MassProperties::point(1.0, Vector3::new(0.5, 0.0, 0.0)).unwrap();
        robot.links.push(LinkDescription::new(link, mass));
        let (kind, at) =
            (JointKind::Revolute { axis: [0.0, 0.0, 1.0] }, Pose::from_translation([x, 0.0, 0.0]));
        robot.joints.push(JointDescription::new(name, kind, parent, link, at).with_limits(limits));
    }
    let ball = Shape::Sphere { radius: 0.1 };
    robot.shapes.push(LinkShape::new("forearm", ShapeRole::Collision, Pose::IDENTITY, ball));
    Model::new(robot).unwrap()
}
