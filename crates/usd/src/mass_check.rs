//! Checks that every degree of freedom moves mass. Otherwise the mass matrix is singular in every pose.

use std::collections::HashMap;

use robot_dynamics_description::{JointKind, RobotDescription};

use crate::findings::Findings;

/// Reports joints whose subtree has no mass. Joints are listed from the root outwards.
pub(crate) fn check(robot: &RobotDescription, findings: &mut Findings) {
    let links = robot.links.iter();
    let mut has_mass: HashMap<&str, bool> =
        links.map(|link| (link.name.as_str(), link.mass_properties.is_some())).collect();
    for joint in robot.joints.iter().rev() {
        if has_mass.get(joint.child.as_str()) == Some(&true) {
            has_mass.insert(joint.parent.as_str(), true);
        }
    }
    for joint in &robot.joints {
        let is_moving = joint.kind != JointKind::Fixed && joint.mimic.is_none();
        if is_moving && joint.passive.armature <= 0.0 && has_mass.get(joint.child.as_str()) == Some(&false) {
            let message = format!(
                "moves link {:?}, but no link of its subtree has mass: the mass matrix is singular, and functions that \
                 need its inverse return an error; give it a mass, or lock the joint",
                joint.child
            );
            findings.warn(&format!("joint {:?}", joint.name), message);
        }
    }
}
