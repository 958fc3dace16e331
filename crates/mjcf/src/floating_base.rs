//! Chooses the body that becomes the floating base.

use std::collections::{HashMap, HashSet};

use robot_dynamics_description::{Base, Disposition, JointKind, RobotDescription};
use robot_dynamics_xml::excerpt;

use crate::MjcfError;
use crate::reader::Reader;
use crate::tree::Tree;

/// The connection of a body to the world.
enum WorldConnection {
    Fixed,
    Free,
    ByJoint(String),
}

/// A child of the world.
struct WorldBody {
    /// Its joint to the world.
    joint: usize,
    name: String,
    connection: WorldConnection,
    /// Whether there are moving joints in its subtree.
    has_joints: bool,
}

/// Gives the robot a floating base: the only child of the world that has joints in its subtree. Other
/// children of the world, such as a table, stay fixed.
///
/// If the world has at most one child and no shapes, the world itself becomes the floating base.
pub(crate) fn add_floating_base(reader: &mut Reader<'_>, robot: &mut RobotDescription) {
    if !reader.options.floating_base {
        return;
    }
    let bodies = bodies_of_the_world(robot);
    let world = robot.links[0].name.clone();
    let is_alone = bodies.len() <= 1 && robot.shapes.iter().all(|shape| shape.link != world);
    if robot.root_floats() {
        let message = "the root link has a floating joint: the floating base is omitted";
        note(reader, Disposition::Ignored { physics: false }, message.into());
        return;
    }
    if is_alone {
        robot.base = Base::Floating;
        return;
    }
    let moving =
        |body: &&WorldBody| body.has_joints || matches!(body.connection, WorldConnection::ByJoint(_));
    let robots: Vec<&WorldBody> = bodies.iter().filter(moving).collect();
    let candidates = if robots.is_empty() {
        bodies.iter().filter(|body| matches!(body.connection, WorldConnection::Fixed)).collect()
    } else {
        robots
    };
    match candidates[..] {
        [] => robot.base = Base::Floating,
        [WorldBody { connection: WorldConnection::Fixed, joint, name, .. }] => {
            let base = robot.floating_base_name();
            let own = &mut robot.joints[*joint];
            (own.kind, own.name) = (JointKind::Floating, base.clone());
            let message = format!(
                "body {name:?} becomes the floating base by the joint {base:?}, whose position is relative to the pose in \
                 the file; the other bodies of the world stay fixed"
            );
            note(reader, Disposition::Defaulted, message);
        }
        [WorldBody { connection: WorldConnection::Free, name, .. }] => {
            let message = format!("body {name:?} has a floating joint: the floating base is omitted");
            note(reader, Disposition::Ignored { physics: false }, message);
        }
        [WorldBody { connection: WorldConnection::ByJoint(joint), name, .. }] => refuse(
            reader,
            format!(
                "body {name:?} cannot be the floating base, because joint {joint:?} connects it to the world; put it into a \
                 body without joints"
            ),
        ),
        _ => {
            let names: Vec<String> = candidates.iter().map(|body| format!("{:?}", body.name)).collect();
            let message = format!(
                "several bodies of the world can be the floating base: {}; add a <freejoint/> to one of them, or load its \
                 file alone",
                names.join(", ")
            );
            refuse(reader, message);
        }
    }
}

/// The children of the world, in the order of the file.
fn bodies_of_the_world(robot: &RobotDescription) -> Vec<WorldBody> {
    let mut below = HashMap::<&str, Vec<usize>>::new();
    for (index, joint) in robot.joints.iter().enumerate() {
        below.entry(&joint.parent).or_default().push(index);
    }
    let has_joints = |link: &str| {
        let (mut seen, mut pending) = (HashSet::new(), vec![link]);
        while let Some(link) = pending.pop() {
            for &joint in below.get(link).into_iter().flatten() {
                let joint = &robot.joints[joint];
                if joint.kind != JointKind::Fixed {
                    return true;
                }
                if seen.insert(joint.child.as_str()) {
                    pending.push(&joint.child);
                }
            }
        }
        false
    };
    let of_the_world = below.get(robot.links[0].name.as_str()).into_iter().flatten();
    of_the_world
        .map(|&index| {
            let joint = &robot.joints[index];
            let connection = match joint.kind {
                JointKind::Fixed => WorldConnection::Fixed,
                JointKind::Floating => WorldConnection::Free,
                _ => WorldConnection::ByJoint(excerpt(&joint.name)),
            };
            let name = excerpt(&joint.child);
            WorldBody { joint: index, name, connection, has_joints: has_joints(&joint.child) }
        })
        .collect()
}

fn note(reader: &mut Reader<'_>, disposition: Disposition, message: String) {
    let (line, place) = (reader.tree.nodes[Tree::ROOT].line, excerpt("mujoco"));
    reader.push(line, place, disposition, message);
}

fn refuse(reader: &mut Reader<'_>, reason: String) {
    let (line, place) = (reader.tree.nodes[Tree::ROOT].line, excerpt("mujoco"));
    reader.errors.push(MjcfError::Misplaced { line, place, reason });
}
