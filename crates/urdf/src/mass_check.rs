//! Checks that every degree of freedom moves mass. Otherwise the mass matrix is singular in every pose.

use robot_dynamics_description::{Base, Disposition, JointKind, RobotDescription};
use robot_dynamics_xml::excerpt;

use crate::reader::Reader;
use crate::tree::{SourceLines, Tree};

/// Reports joints that move no mass, and joints whose child link has no mass.
///
/// A joint moves the links of its subtree, and the subtrees of its mimic joints.
pub(crate) fn check(
    robot: &RobotDescription,
    tree: &Tree,
    leaders: &[Option<usize>],
    lines: &SourceLines,
    reader: &mut Reader<'_>,
) {
    let has_mass: Vec<bool> = robot.links.iter().map(|link| link.mass_properties.is_some()).collect();
    // Whether the subtree of each link has mass, and whether the rigid body that starts at the link has.
    let mut from_here = has_mass.clone();
    let mut rigid = has_mass;
    for &link in tree.order.iter().rev() {
        if let Some(joint) = tree.joint_above[link] {
            let parent = tree.ends[joint].0;
            from_here[parent] |= from_here[link];
            rigid[parent] |= rigid[link] && robot.joints[joint].kind == JointKind::Fixed;
        }
    }
    if robot.base == Base::Floating && !tree.order.first().is_some_and(|&root| from_here[root]) {
        let message = "the base floats, but no link has mass: the mass matrix is singular in every pose; give a \
                       link an <inertial>";
        reader.push(lines.robot, "robot".into(), Disposition::AsWritten, message.into());
    }
    let mut moves: Vec<bool> = tree
        .ends
        .iter()
        .zip(&robot.joints)
        .map(|(&(_, child), joint)| from_here[child] || joint.passive.armature > 0.0)
        .collect();
    // A leader moves the mass that its mimic joints move. Each leader is marked once.
    for mimic_joint in 0..leaders.len() {
        let mut at = mimic_joint;
        while let Some(leader) = leaders[at].filter(|&leader| moves[at] && !moves[leader]) {
            moves[leader] = true;
            at = leader;
        }
    }
    for (at, joint) in robot.joints.iter().enumerate() {
        let (_, child) = tree.ends[at];
        if joint.kind == JointKind::Fixed || rigid[child] {
            continue;
        }
        let (place, child) = (format!("joint {:?}", excerpt(&joint.name)), excerpt(&joint.child));
        if !moves[at] && leaders[at].is_none() {
            let message = format!(
                "moves link {child:?}, but no link of its subtree has mass: the mass matrix is singular, and functions \
                 that need its inverse return an error; give {child:?} an <inertial>, or lock the joint"
            );
            reader.push(lines.joints[at], place, Disposition::AsWritten, message);
        } else {
            let message = format!(
                "moves link {child:?}, which has no mass; the mass matrix may be singular in some poses"
            );
            reader.push(lines.joints[at], place, Disposition::Defaulted, message);
        }
    }
}
