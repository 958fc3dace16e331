//! Checks mimic joints: the leader exists, both joints have one degree of freedom, and there are no cycles.

use std::collections::HashMap;

use robot_dynamics_description::RobotDescription;
use robot_dynamics_xml::excerpt;

use crate::UrdfError;
use crate::tree::{SourceLines, joint_names};

/// The leader of each mimic joint, by joint index. Adds what is wrong to `errors`.
pub(crate) fn find_leaders(
    robot: &RobotDescription,
    lines: &SourceLines,
    errors: &mut Vec<UrdfError>,
) -> Vec<Option<usize>> {
    let index: HashMap<&str, usize> =
        robot.joints.iter().enumerate().map(|(at, joint)| (joint.name.as_str(), at)).collect();
    let mut leaders = vec![None; robot.joints.len()];
    for (at, joint) in robot.joints.iter().enumerate() {
        // A leader without a name has its own error.
        let Some(mimic) = joint.mimic.as_ref().filter(|mimic| !mimic.joint.is_empty()) else { continue };
        let Some(&leader) = index.get(mimic.joint.as_str()) else {
            errors.push(UrdfError::UnknownMimic {
                line: lines.joints[at],
                joint: excerpt(&joint.name),
                leader: excerpt(&mimic.joint),
            });
            continue;
        };
        // Both must have one degree of freedom.
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
    list_mimic_cycles(&leaders, robot, lines, errors);
    leaders
}

/// Follows the leaders from every joint; each joint is visited once.
fn list_mimic_cycles(
    leaders: &[Option<usize>],
    robot: &RobotDescription,
    lines: &SourceLines,
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
        // The walk has returned to a joint that it visited, which is a mimic joint: a cycle.
        if walk_of[at] == start && leaders[at].is_some() {
            let mut ring = vec![at];
            let mut next = leaders[at];
            while let Some(joint) = next.filter(|&joint| joint != at) {
                ring.push(joint);
                next = leaders[joint];
            }
            ring.push(at);
            errors
                .push(UrdfError::MimicCycle { line: lines.joints[start], joints: joint_names(&ring, robot) });
        }
    }
}
