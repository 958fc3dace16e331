//! Mimic joints must follow a joint that is there, is alike, and is free in the end.

use std::collections::HashMap;

use multibody::RobotDescription;

use crate::UrdfError;
use crate::tree::{Places, names};
use robot_xml::excerpt;

/// For each joint the joint that it follows; what is wrong is added to `errors`.
pub(crate) fn leaders(
    robot: &RobotDescription,
    lines: &Places,
    errors: &mut Vec<UrdfError>,
) -> Vec<Option<usize>> {
    let index: HashMap<&str, usize> =
        robot.joints.iter().enumerate().map(|(at, joint)| (joint.name.as_str(), at)).collect();
    let mut leaders = vec![None; robot.joints.len()];
    for (at, joint) in robot.joints.iter().enumerate() {
        // A leader without a name is an error already.
        let Some(mimic) = joint.mimic.as_ref().filter(|mimic| !mimic.joint.is_empty()) else { continue };
        let Some(&leader) = index.get(mimic.joint.as_str()) else {
            errors.push(UrdfError::UnknownMimic {
                line: lines.joints[at],
                joint: excerpt(&joint.name),
                leader: excerpt(&mimic.joint),
            });
            continue;
        };
        // One number that turns or slides.
        let unfit = [at, leader].into_iter().find(|&other| robot.joints[other].kind.nv() != 1);
        if let Some(other) = unfit {
            errors.push(UrdfError::MimicKind {
                line: lines.joints[at],
                joint: excerpt(&joint.name),
                leader: excerpt(&mimic.joint),
                which: format!("{:?}", excerpt(&robot.joints[other].name)),
                kind: robot.joints[other].kind.name(),
            });
            continue;
        }
        leaders[at] = Some(leader);
    }
    refuse_rings(&leaders, robot, lines, errors);
    leaders
}

/// Walks from every joint to its leaders; each joint is walked over once.
fn refuse_rings(
    leaders: &[Option<usize>],
    robot: &RobotDescription,
    lines: &Places,
    errors: &mut Vec<UrdfError>,
) {
    let mut walk_of = vec![usize::MAX; leaders.len()];
    for start in 0..leaders.len() {
        let mut at = start;
        while walk_of[at] == usize::MAX {
            walk_of[at] = start;
            match leaders[at] {
                Some(leader) => at = leader,
                None => break,
            }
        }
        // Back on this walk's own track, and still following: a ring.
        if walk_of[at] == start && leaders[at].is_some() {
            let mut ring = vec![at];
            let mut next = leaders[at];
            while let Some(joint) = next.filter(|&joint| joint != at) {
                ring.push(joint);
                next = leaders[joint];
            }
            ring.push(at);
            errors.push(UrdfError::MimicCycle { line: lines.joints[start], joints: names(&ring, robot) });
        }
    }
}
