//! Robots for tests.

use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::Model;

/// A chain of links, each 0.1 m long and with this mass; links of equal mass are alike.
pub(crate) fn chain(masses: &[f64]) -> Model {
    let mut robot = RobotDescription::new("chain");
    robot.links.push(LinkDescription::new("base", None));
    let mut parent = "base".to_owned();
    for (k, &mass) in masses.iter().enumerate() {
        let name = format!("link{k}");
        // The points are off the axes, so that no moment is zero.
        let points = [[0.05, 0.02, 0.01], [0.02, -0.01, 0.03], [0.1, 0.01, -0.02], [0.06, -0.03, 0.01]];
        let parts = points.map(|point| MassProperties::point(0.25 * mass, point.into()).unwrap());
        robot.links.push(LinkDescription::new(&name, MassProperties::composite(&parts).unwrap()));
        let about_z = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
        let pose = Pose::from_xyz_rpy([0.1, 0.0, 0.0], [0.5, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("joint{k}"), about_z, &parent, &name, pose));
        parent = name;
    }
    Model::new(robot).unwrap()
}
