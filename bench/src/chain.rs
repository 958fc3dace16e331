//! Chains of any length, for the growth of costs.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};

/// A chain of equal thin rods of 0.2 m and 0.5 kg, with joints about z and y alternately.
///
/// # Panics
/// Panics if the rods' mass properties are invalid, which they are not.
pub fn chain(links: usize) -> RobotDescription {
    let (length, mass, radius) = (0.2, 0.5, 0.02);
    let across = mass * (length * length / 12.0 + radius * radius / 4.0);
    let inertia = Matrix3::from_diagonal(&Vector3::new(across, across, mass * radius * radius / 2.0));
    let rod = MassProperties::new(mass, Vector3::new(0.0, 0.0, length / 2.0), inertia).expect("a solid rod");
    let mut robot = RobotDescription::new(format!("chain_{links}"));
    robot.links.push(LinkDescription::new("base", None));
    for i in 0..links {
        let parent = robot.links[i].name.clone();
        let child = format!("rod_{i}");
        let axis = if i % 2 == 0 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let place = Pose::from_translation([0.0, 0.0, if i == 0 { 0.0 } else { length }]);
        let kind = JointKind::Revolute { axis };
        robot.links.push(LinkDescription::new(child.clone(), rod));
        robot.joints.push(JointDescription::new(format!("joint_{i}"), kind, parent, child, place));
    }
    robot
}
