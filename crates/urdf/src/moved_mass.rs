//! Every free motion must move some mass: otherwise the mass matrix is singular in every pose.

use multibody::{Base, JointKind, RobotDescription};

use crate::UrdfError;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::report::Treatment;
use crate::tree::{Places, Tree};

/// Refuses joints that accelerate nothing, and lists joints whose own link has no mass.
///
/// A joint moves the links from its child on, and the links of every joint that follows it.
pub(crate) fn check(
    robot: &RobotDescription,
    tree: &Tree,
    leaders: &[Option<usize>],
    lines: &Places,
    reader: &mut Reader<'_>,
) -> Result<(), UrdfError> {
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
        return Err(UrdfError::NoMassAtAll { line: lines.robot, robot: excerpt(&robot.name) });
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
        if !moves[at] && leaders[at].is_none() {
            return Err(UrdfError::NoMassMoved {
                line: lines.joints[at],
                joint: excerpt(&joint.name),
                link: excerpt(&joint.child),
            });
        }
        let message = format!(
            "moves link {:?}, which has no mass of its own; the mass matrix may be singular in some poses",
            excerpt(&joint.child)
        );
        let place = format!("joint {:?}", excerpt(&joint.name));
        reader.push(lines.joints[at], place, Treatment::Defaulted, message);
    }
    Ok(())
}
