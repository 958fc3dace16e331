//! The body that floats where a floating base is asked for.

use std::collections::{HashMap, HashSet};

use multibody::{Base, JointKind, RobotDescription, Treatment};
use robot_xml::excerpt;

use crate::MjcfError;
use crate::reader::Reader;
use crate::tree::Tree;

/// How a body hangs in the world.
enum Hangs {
    Fixed,
    Free,
    ByJoint(String),
}

/// A body of the world with all that it carries.
struct WorldBody {
    /// Its joint to the world.
    joint: usize,
    name: String,
    hangs: Hangs,
    /// Whether joints move what it carries.
    has_joints: bool,
}

/// Frees the robot's base: the one body of the world that carries joints. A table and a floor stay where they are.
///
/// A file of one robot alone has its world freed, which is the robot's base by another name.
pub(crate) fn free_base(reader: &mut Reader<'_>, robot: &mut RobotDescription) {
    if !reader.options.floating_base {
        return;
    }
    let bodies = bodies_of_the_world(robot);
    let world = robot.links[0].name.clone();
    let is_alone = bodies.len() <= 1 && robot.shapes.iter().all(|shape| shape.link != world);
    if robot.root_floats() {
        let message = "the root floats by a joint of its own: a floating base adds nothing and is left out";
        note(reader, Treatment::Ignored { physics: false }, message.into());
        return;
    }
    if is_alone {
        robot.base = Base::Floating;
        return;
    }
    let moving = |body: &&WorldBody| body.has_joints || matches!(body.hangs, Hangs::ByJoint(_));
    let robots: Vec<&WorldBody> = bodies.iter().filter(moving).collect();
    let candidates = if robots.is_empty() {
        bodies.iter().filter(|body| matches!(body.hangs, Hangs::Fixed)).collect()
    } else {
        robots
    };
    match candidates[..] {
        [] => robot.base = Base::Floating,
        [WorldBody { hangs: Hangs::Fixed, joint, name, .. }] => {
            let base = robot.floating_base_name();
            let own = &mut robot.joints[*joint];
            (own.kind, own.name) = (JointKind::Floating, base.clone());
            let message = format!(
                "body {name:?} is freed with all that it carries, by the joint {base:?}, whose position counts from where the file \
                 places it; the other bodies of the world stay"
            );
            note(reader, Treatment::Defaulted, message);
        }
        [WorldBody { hangs: Hangs::Free, name, .. }] => {
            let message = format!(
                "body {name:?} floats by a joint of its own: a floating base adds nothing and is left out"
            );
            note(reader, Treatment::Ignored { physics: false }, message);
        }
        [WorldBody { hangs: Hangs::ByJoint(joint), name, .. }] => refuse(
            reader,
            format!(
                "a floating base is asked for, but body {name:?} hangs in the world by joint {joint:?} and has no base; put it into a body \
                 without joints"
            ),
        ),
        _ => {
            let names: Vec<String> = candidates.iter().map(|body| format!("{:?}", body.name)).collect();
            let message = format!(
                "a floating base is asked for, but several bodies of the world may be meant: {}; write <freejoint/> into the one that \
                 floats, or load its file alone",
                names.join(", ")
            );
            refuse(reader, message);
        }
    }
}

/// The bodies that hang in the world, in the file's order.
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
            let hangs = match joint.kind {
                JointKind::Fixed => Hangs::Fixed,
                JointKind::Floating => Hangs::Free,
                _ => Hangs::ByJoint(excerpt(&joint.name)),
            };
            let name = excerpt(&joint.child);
            WorldBody { joint: index, name, hangs, has_joints: has_joints(&joint.child) }
        })
        .collect()
}

fn note(reader: &mut Reader<'_>, treatment: Treatment, message: String) {
    let (line, place) = (reader.tree.nodes[Tree::ROOT].line, excerpt("mujoco"));
    reader.push(line, place, treatment, message);
}

fn refuse(reader: &mut Reader<'_>, reason: String) {
    let (line, place) = (reader.tree.nodes[Tree::ROOT].line, excerpt("mujoco"));
    reader.errors.push(MjcfError::Misplaced { line, place, reason });
}
