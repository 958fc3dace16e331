//! How the robot hangs in the world: a link `world` that the file does not list, several roots, a floating base.

use std::collections::HashSet;

use multibody::{
    Base, FLOATING_BASE, JointDescription, JointKind, LinkDescription, Pose, RobotDescription, Treatment,
};

use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Places;
use robot_xml::excerpt;

const WORLD: &str = "world";

/// A link `world` that joints hang on, but that the file does not list, is the world.
pub(crate) fn add_missing(reader: &mut Reader<'_>, robot: &mut RobotDescription, lines: &mut Places) {
    let hangs = |joint: &JointDescription| joint.parent == WORLD;
    let is_listed = robot.links.iter().any(|link| link.name == WORLD);
    if let Some(at) = robot.joints.iter().position(hangs).filter(|_| !is_listed) {
        let (line, place) = (lines.joints[at], format!("joint {:?}", excerpt(&robot.joints[at].name)));
        let message = "its parent link \"world\" is not in the file: taken as the world";
        reader.push(line, place, Treatment::Defaulted, message.into());
        add_world(robot, lines, line);
    }
}

fn add_world(robot: &mut RobotDescription, lines: &mut Places, line: usize) {
    robot.links.push(LinkDescription::new(WORLD, None));
    lines.links.push(line);
}

/// Links that no joint carries each stand in the world, where it is one robot with one root in the end.
pub(crate) fn fix_roots(
    reader: &mut Reader<'_>,
    robot: &mut RobotDescription,
    lines: &mut Places,
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
            "one of {} links that no joint carries: each is fixed to the world where its frame is; connect them by \
             joints if they belong together",
            roots.len()
        );
        reader.push(line, format!("link {:?}", excerpt(&name)), Treatment::AsWritten, message);
        let mut joint = format!("{WORLD}_to_{name}");
        while !names.insert(joint.clone()) {
            joint.push('_');
        }
        robot.joints.push(JointDescription::new(joint, JointKind::Fixed, WORLD, name, Pose::IDENTITY));
        lines.joints.push(line);
    }
}

/// Frees the root link, unless it floats already.
pub(crate) fn free_base<'a>(reader: &mut Reader<'a>, robot: &mut RobotDescription, element: &Element<'a>) {
    let place = element.place.clone();
    if robot.root_floats() {
        let message = "the root floats by a joint of its own: a floating base adds nothing and is left out";
        reader.ignored(element.line, place, message);
        return;
    }
    robot.base = Base::Floating;
    let name = robot.floating_base_name();
    if name != FLOATING_BASE {
        let message = format!("a joint of the file is named {FLOATING_BASE:?}: the base's own is {name:?}");
        reader.push(element.line, place, Treatment::Defaulted, message);
    }
}
