//! Checks that links and joints form a tree.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use robot_dynamics_description::RobotDescription;
use robot_dynamics_xml::excerpt;

use crate::UrdfError;

/// The tree of links by indices.
pub(crate) struct Tree {
    /// The links that are not the child of a joint.
    pub(crate) roots: Vec<usize>,
    /// For each link the joint whose child it is; `None` for a root.
    pub(crate) joint_above: Vec<Option<usize>>,
    /// For each joint its parent and child link.
    pub(crate) ends: Vec<(usize, usize)>,
    /// The links, each after its parent.
    pub(crate) order: Vec<usize>,
}

/// The lines at which the robot, each link and each joint begin.
pub(crate) struct SourceLines {
    pub(crate) robot: usize,
    pub(crate) links: Vec<usize>,
    pub(crate) joints: Vec<usize>,
}

impl Tree {
    /// Checks names and connections. Adds what is wrong to `errors` and then returns `None`.
    pub(crate) fn of(
        robot: &RobotDescription,
        lines: &SourceLines,
        errors: &mut Vec<UrdfError>,
    ) -> Option<Self> {
        if robot.links.is_empty() && errors.is_empty() {
            errors.push(UrdfError::NoLinks { line: lines.robot, robot: excerpt(&robot.name) });
        }
        let links =
            index_names("link", robot.links.iter().map(|link| link.name.as_str()), &lines.links, errors);
        index_names("joint", robot.joints.iter().map(|joint| joint.name.as_str()), &lines.joints, errors);
        let mut ends = Vec::with_capacity(robot.joints.len());
        let mut joint_above: Vec<Option<usize>> = vec![None; robot.links.len()];
        for (at, joint) in robot.joints.iter().enumerate() {
            let line = lines.joints[at];
            let mut find = |role: &'static str, link: &str| {
                let found = links.get(link).copied();
                // A link without a name has its own error.
                if found.is_none() && !link.is_empty() {
                    let (joint, link) = (excerpt(&joint.name), excerpt(link));
                    errors.push(UrdfError::UnknownLink { line, joint, role, link });
                }
                found
            };
            let (parent, child) = (find("parent", &joint.parent), find("child", &joint.child));
            let (Some(parent), Some(child)) = (parent, child) else { continue };
            if parent == child {
                errors.push(UrdfError::SelfParent {
                    line,
                    joint: excerpt(&joint.name),
                    link: excerpt(&joint.child),
                });
                continue;
            }
            if let Some(first) = joint_above[child] {
                errors.push(UrdfError::TwoParents {
                    line,
                    link: excerpt(&joint.child),
                    joint: excerpt(&joint.name),
                    first_joint: excerpt(&robot.joints[first].name),
                    first: lines.joints[first],
                });
                continue;
            }
            joint_above[child] = Some(at);
            ends.push((at, parent, child));
        }
        let has_all_joints = ends.len() == robot.joints.len();
        let mut all_ends = vec![(usize::MAX, usize::MAX); robot.joints.len()];
        for &(at, parent, child) in &ends {
            all_ends[at] = (parent, child);
        }
        let roots: Vec<usize> = (0..robot.links.len()).filter(|&link| joint_above[link].is_none()).collect();
        let order = breadth_first(&roots, &ends, robot.links.len());
        let tree = Self { roots, joint_above, ends: all_ends, order };
        tree.list_cycles(robot, lines, errors);
        (has_all_joints && errors.is_empty()).then_some(tree)
    }

    /// The parent of a link.
    pub(crate) fn parent(&self, link: usize) -> Option<usize> {
        self.joint_above[link].map(|joint| self.ends[joint].0)
    }

    /// Lists the cycles among the links that no root reaches. From any of them the way up ends in a cycle.
    fn list_cycles(&self, robot: &RobotDescription, lines: &SourceLines, errors: &mut Vec<UrdfError>) {
        let mut walk_of = vec![usize::MAX; robot.links.len()];
        for &link in &self.order {
            walk_of[link] = link;
        }
        for start in 0..robot.links.len() {
            let mut link = start;
            if walk_of[link] != usize::MAX {
                continue;
            }
            while walk_of[link] == usize::MAX {
                // The offset distinguishes this walk from links that a root reaches.
                walk_of[link] = robot.links.len() + start;
                link = self.parent(link).unwrap_or(link);
            }
            if walk_of[link] != robot.links.len() + start {
                continue;
            }
            let first = link;
            let mut ring = Vec::new();
            while let Some(joint) = self.joint_above[link] {
                ring.push(joint);
                link = self.ends[joint].0;
                if link == first {
                    break;
                }
            }
            ring.reverse();
            let line = ring.iter().map(|&joint| lines.joints[joint]).min().unwrap_or(lines.robot);
            errors.push(UrdfError::Cycle { line, joints: joint_names(&ring, robot) });
        }
    }
}

/// The names of the joints, at most ten.
pub(crate) fn joint_names(joints: &[usize], robot: &RobotDescription) -> Vec<String> {
    let mut names: Vec<String> =
        joints.iter().take(10).map(|&joint| format!("{:?}", excerpt(&robot.joints[joint].name))).collect();
    if joints.len() > names.len() {
        names.push(format!("{} more", joints.len() - names.len()));
    }
    names
}

/// Maps names to indices. A repeated name is an error.
fn index_names<'n>(
    what: &'static str,
    names: impl Iterator<Item = &'n str>,
    lines: &[usize],
    errors: &mut Vec<UrdfError>,
) -> HashMap<&'n str, usize> {
    let mut index = HashMap::new();
    // An empty name has its own error.
    for (at, name) in names.enumerate().filter(|(_, name)| !name.is_empty()) {
        match index.entry(name) {
            Entry::Vacant(entry) => {
                entry.insert(at);
            }
            Entry::Occupied(entry) => {
                let (line, first) = (lines[at], lines[*entry.get()]);
                errors.push(UrdfError::DuplicateName { line, what, name: excerpt(name), first });
            }
        }
    }
    index
}

/// All links that the roots reach, parents first. `ends` are joints as (index, parent, child).
fn breadth_first(roots: &[usize], ends: &[(usize, usize, usize)], links: usize) -> Vec<usize> {
    let mut children = vec![Vec::new(); links];
    for &(_, parent, child) in ends {
        children[parent].push(child);
    }
    let mut order = roots.to_vec();
    let mut next = 0;
    while next < order.len() {
        order.extend_from_slice(&children[order[next]]);
        next += 1;
    }
    order
}
