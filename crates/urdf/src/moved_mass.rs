//! Every free motion should move some mass: otherwise the mass matrix is singular in every pose.

use multibody::{Base, JointKind, RobotDescription, Treatment};

use crate::reader::Reader;
use crate::tree::{Places, Tree};
use robot_xml::excerpt;

/// Lists joints that accelerate nothing, and joints whose own link has no mass.
///
/// A joint moves the links from its child on, and the links of every joint that follows it.
pub(crate) fn check(
    robot: &RobotDescription,
    tree: &Tree,
    leaders: &[Option<usize>],
    lines: &Places,
    reader: &mut Reader<'_>,
) {
    let has_mass: Vec<bool> = robot.links.iter().map(|link| link.mass_properties.is_some()).collect();
    // Mass anywhere from the link on, and mass in the rigid body that the link begins.
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
        let message = "the base floats, but no link has mass: the mass matrix is singular in every pose; give one \
                       an <inertial>";
        reader.push(lines.robot, "robot".into(), Treatment::AsWritten, message.into());
    }
    let mut moves: Vec<bool> = tree
        .ends
        .iter()
        .zip(&robot.joints)
        .map(|(&(_, child), joint)| from_here[child] || joint.passive.armature > 0.0)
        .collect();
    // Mass moved by a follower is moved by its leader. Followers that move none pass nothing on, and each
    // leader is marked once.
    for follower in 0..leaders.len() {
        let mut at = follower;
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
                "moves link {child:?}, but no link from there on has mass: any force means infinite acceleration, and \
                 whatever needs the inverse of the mass matrix is refused; give {child:?} an <inertial>, or lock the joint"
            );
            reader.push(lines.joints[at], place, Treatment::AsWritten, message);
        } else {
            let message = format!(
                "moves link {child:?}, which has no mass of its own; the mass matrix may be singular in some poses"
            );
            reader.push(lines.joints[at], place, Treatment::Defaulted, message);
        }
    }
}
