//! The small robots that the messages are about.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::description::{
    Base, FrameDescription, JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose,
    RobotDescription, Shape, ShapeRole,
};

pub(crate) const Z: JointKind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };

fn link(name: &str) -> LinkDescription {
    let body = MassProperties::new(1.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::identity()).expect("a body");
    LinkDescription::new(name, body)
}

pub(crate) fn joint(name: &str, kind: JointKind, parent: &str, child: &str) -> JointDescription {
    JointDescription::new(name, kind, parent, child, Pose::from_translation([0.5, 0.0, 0.0]))
}

/// base –shoulder– arm –elbow– hand.
pub(crate) fn arm() -> RobotDescription {
    let mut robot = RobotDescription::new("arm");
    robot.links = ["base", "arm", "hand"].map(link).into();
    robot.joints = vec![joint("shoulder", Z, "base", "arm"), joint("elbow", Z, "arm", "hand")];
    robot
}

/// The arm on a floating base.
pub(crate) fn floating_arm() -> RobotDescription {
    let mut robot = arm();
    robot.base = Base::Floating;
    robot
}

/// Joints `yaw`, `pitch` and `spin`; M is singular at pitch 0, where yaw and spin have one axis.
pub(crate) fn gimbal() -> RobotDescription {
    let mut robot = RobotDescription::new("gimbal");
    let point = |at: [f64; 3]| MassProperties::point(1.0, Vector3::from(at)).ok();
    robot.links.push(LinkDescription::new("base", None));
    robot.links.push(LinkDescription::new("ring", point([0.0, 0.0, 0.5])));
    robot.links.push(LinkDescription::new("fork", point([0.0, 0.0, 0.3])));
    robot.links.push(LinkDescription::new("rotor", point([0.0, 0.4, 0.2])));
    let turn = |name: &str, axis, parent: &str, child: &str| {
        JointDescription::new(name, JointKind::Revolute { axis }, parent, child, Pose::IDENTITY)
    };
    robot.joints.push(turn("yaw", [0.0, 0.0, 1.0], "base", "ring"));
    robot.joints.push(turn("pitch", [0.0, 1.0, 0.0], "ring", "fork"));
    robot.joints.push(turn("spin", [0.0, 0.0, 1.0], "fork", "rotor"));
    robot
}

/// An arm in the vertical plane of x and z, with a frame `tip`.
pub(crate) fn planar_arm() -> RobotDescription {
    let mut robot = RobotDescription::new("planar");
    robot.links.push(LinkDescription::new("base", None));
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, 0.1, 0.1));
    for (i, (name, parent)) in [("upper", "base"), ("fore", "upper")].into_iter().enumerate() {
        let rod = MassProperties::new(1.0, Vector3::new(0.5, 0.0, 0.0), inertia).expect("a rod");
        robot.links.push(LinkDescription::new(name, rod));
        let hinge = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
        let at = Pose::from_translation([i as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(["shoulder", "elbow"][i], hinge, parent, name, at));
    }
    robot.frames.push(FrameDescription::new("tip", "fore", Pose::from_translation([0.8, 0.0, 0.0])));
    robot
}

/// Two free bodies with shapes for collisions.
pub(crate) fn two_bodies(shapes: [Shape; 2]) -> RobotDescription {
    let mut robot = RobotDescription::new("bodies");
    robot.links.push(LinkDescription::new("world", None));
    for (k, shape) in shapes.into_iter().enumerate() {
        let name = format!("body{k}");
        let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 0.1).expect("a body");
        robot.links.push(LinkDescription::new(&name, mass));
        robot.joints.push(joint(&format!("free{k}"), JointKind::Floating, "world", &name));
        let shape = LinkShape::new(&name, ShapeRole::Collision, Pose::IDENTITY, shape);
        robot.shapes.push(shape.with_name(format!("shape{k}")));
    }
    robot
}
