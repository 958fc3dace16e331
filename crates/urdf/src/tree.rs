//! The links and joints must form one tree.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use multibody::{Base, FLOATING_BASE, RobotDescription};

use crate::UrdfError;
use crate::error::excerpt;

/// The links' tree by indices: who moves whom.
pub(crate) struct Tree {
    /// For each link the joint that it is the child of; `None` for the root.
    pub(crate) joint_above: Vec<Option<usize>>,
    /// For each joint its parent link and its child link.
    pub(crate) ends: Vec<(usize, usize)>,
    /// The links, each after its parent.
    pub(crate) order: Vec<usize>,
}

/// Where each link and each joint begins in the file.
pub(crate) struct Places {
    pub(crate) robot: usize,
    pub(crate) links: Vec<usize>,
    pub(crate) joints: Vec<usize>,
}

impl Tree {
    /// Checks names and connections.
    pub(crate) fn of(robot: &RobotDescription, lines: &Places) -> Result<Self, UrdfError> {
        if robot.links.is_empty() {
            return Err(UrdfError::NoLinks { line: lines.robot, robot: excerpt(&robot.name) });
        }
        let links = index("link", robot.links.iter().map(|link| link.name.as_str()), &lines.links)?;
        let joints = index("joint", robot.joints.iter().map(|joint| joint.name.as_str()), &lines.joints)?;
        if let (Base::Floating, Some(&joint)) = (robot.base, joints.get(FLOATING_BASE)) {
            return Err(UrdfError::ReservedName {
                line: lines.joints[joint],
                name: FLOATING_BASE.to_owned(),
            });
        }
        let mut ends = Vec::with_capacity(robot.joints.len());
        let mut joint_above: Vec<Option<usize>> = vec![None; robot.links.len()];
        for (at, joint) in robot.joints.iter().enumerate() {
            let line = lines.joints[at];
            let find = |role: &'static str, link: &str| {
                links.get(link).copied().ok_or_else(|| UrdfError::UnknownLink {
                    line,
                    joint: excerpt(&joint.name),
                    role,
                    link: excerpt(link),
                })
            };
            let (parent, child) = (find("parent", &joint.parent)?, find("child", &joint.child)?);
            if parent == child {
                return Err(UrdfError::SelfParent {
                    line,
                    joint: excerpt(&joint.name),
                    link: excerpt(&joint.child),
                });
            }
            if let Some(first) = joint_above[child].replace(at) {
                return Err(UrdfError::TwoParents {
                    line,
                    link: excerpt(&joint.child),
                    joint: excerpt(&joint.name),
                    first_joint: excerpt(&robot.joints[first].name),
                    first: lines.joints[first],
                });
            }
            ends.push((parent, child));
        }
        let roots: Vec<usize> = (0..robot.links.len()).filter(|&link| joint_above[link].is_none()).collect();
        if let [first, second, ..] = roots[..] {
            return Err(UrdfError::SeveralRoots {
                line: lines.links[second],
                first_root: excerpt(&robot.links[first].name),
                first: lines.links[first],
                second: excerpt(&robot.links[second].name),
                count: roots.len(),
            });
        }
        let order = breadth_first(&roots, &ends, robot.links.len());
        let tree = Self { joint_above, ends, order };
        if tree.order.len() < robot.links.len() { Err(tree.cycle(robot, lines)) } else { Ok(tree) }
    }

    /// The link that `link` hangs on.
    pub(crate) fn parent(&self, link: usize) -> Option<usize> {
        self.joint_above[link].map(|joint| self.ends[joint].0)
    }

    /// A ring among the links that the root does not reach: walking up from one of them must repeat.
    fn cycle(&self, robot: &RobotDescription, lines: &Places) -> UrdfError {
        let mut reached = vec![false; robot.links.len()];
        for &link in &self.order {
            reached[link] = true;
        }
        let mut link = reached.iter().position(|&reached| !reached).unwrap_or_default();
        while !reached[link] {
            reached[link] = true;
            link = self.parent(link).unwrap_or(link);
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
        UrdfError::Cycle { line, joints: names(&ring, robot) }
    }
}

/// The joints' names, at most ten of them.
pub(crate) fn names(joints: &[usize], robot: &RobotDescription) -> Vec<String> {
    let mut names: Vec<String> =
        joints.iter().take(10).map(|&joint| format!("{:?}", excerpt(&robot.joints[joint].name))).collect();
    if joints.len() > names.len() {
        names.push(format!("{} more", joints.len() - names.len()));
    }
    names
}

/// Name to index; a second one of the same name is an error.
fn index<'n>(
    what: &'static str,
    names: impl Iterator<Item = &'n str>,
    lines: &[usize],
) -> Result<HashMap<&'n str, usize>, UrdfError> {
    let mut index = HashMap::new();
    for (at, name) in names.enumerate() {
        match index.entry(name) {
            Entry::Vacant(entry) => {
                entry.insert(at);
            }
            Entry::Occupied(entry) => {
                let (line, first) = (lines[at], lines[*entry.get()]);
                return Err(UrdfError::DuplicateName { line, what, name: excerpt(name), first });
            }
        }
    }
    Ok(index)
}

/// Every link that the roots reach, parents first.
fn breadth_first(roots: &[usize], ends: &[(usize, usize)], links: usize) -> Vec<usize> {
    let mut children = vec![Vec::new(); links];
    for &(parent, child) in ends {
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
