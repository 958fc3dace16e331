//! Connects the robot to the world: a missing link `world`, several roots, a floating base.

use std::collections::HashSet;

use robot_dynamics_description::{
    Base, Disposition, FLOATING_BASE, JointDescription, JointKind, LinkDescription, Pose, RobotDescription,
};
use robot_dynamics_xml::excerpt;

use crate::element::Element;
use crate::reader::Reader;
use crate::tree::SourceLines;

const WORLD: &str = "world";

/// Adds a link `world` if it is the parent of a joint and missing in the file.
pub(crate) fn add_missing_world(
    reader: &mut Reader<'_>,
    robot: &mut RobotDescription,
    lines: &mut SourceLines,
) {
    let has_world_as_parent = |joint: &JointDescription| joint.parent == WORLD;
    let is_listed = robot.links.iter().any(|link| link.name == WORLD);
    if let Some(at) = robot.joints.iter().position(has_world_as_parent).filter(|_| !is_listed) {
        let (line, place) = (lines.joints[at], format!("joint {:?}", excerpt(&robot.joints[at].name)));
        let message = "its parent link \"world\" is missing: taken as the world";
        reader.push(line, place, Disposition::Defaulted, message.into());
        add_world(robot, lines, line);
    }
}

fn add_world(robot: &mut RobotDescription, lines: &mut SourceLines, line: usize) {
    robot.links.push(LinkDescription::new(WORLD, None));
    lines.links.push(line);
}

/// Fixes every root to the world, so that the robot has one root.
pub(crate) fn fix_roots(
    reader: &mut Reader<'_>,
    robot: &mut RobotDescription,
    lines: &mut SourceLines,
    roots: &[usize],
) {
    let world = robot.links.iter().position(|link| link.name == WORLD);
    if world.is_none() {
        add_world(robot, lines, lines.robot);
    }
    let mut names: HashSet<String> = robot.joints.iter().map(|joint| joint.name.clone()).collect();
    for &root in roots.iter().filter(|&&root| Some(root) != world) {
        let (name, line) = (robot.links[root].name.clone(), lines.links[root]);
        let message = format!(
            "one of {} links without a parent joint: each is fixed to the origin of the world; connect them by joints \
             if they are one robot",
            roots.len()
        );
        reader.push(line, format!("link {:?}", excerpt(&name)), Disposition::AsWritten, message);
        let mut joint = format!("{WORLD}_to_{name}");
        while !names.insert(joint.clone()) {
            joint.push('_');
        }
        robot.joints.push(JointDescription::new(joint, JointKind::Fixed, WORLD, name, Pose::IDENTITY));
        lines.joints.push(line);
    }
}

/// Gives the robot a floating base, unless its root link floats.
pub(crate) fn add_floating_base<'a>(
    reader: &mut Reader<'a>,
    robot: &mut RobotDescription,
    element: &Element<'a>,
) {
    let place = element.place.clone();
    if robot.root_floats() {
        let message = "the root link has a floating joint: the floating base is omitted";
        reader.report_ignored(element.line, place, message);
        return;
    }
    robot.base = Base::Floating;
    let name = robot.floating_base_name();
    if name != FLOATING_BASE {
        let message = format!(
            "a joint of the file is named {FLOATING_BASE:?}: the joint of the base is named {name:?}"
        );
        reader.push(element.line, place, Disposition::Defaulted, message);
    }
}
