//! The tree of a description's joints.

use std::collections::HashMap;

use crate::{ModelError, RobotDescription};

/// The tree of the joints.
pub struct Tree {
    /// Index of the root link.
    pub root: usize,
    /// For each link its child joints, in the description's order.
    pub children: Vec<Vec<usize>>,
    /// Mimic joints, leaders before their mimic joints.
    pub mimic_joints: Vec<usize>,
}

/// Checks that there is one root, that every other link is the child of one joint, and that the root reaches
/// every link.
pub(super) fn span(description: &RobotDescription, links: &HashMap<&str, usize>) -> Result<Tree, ModelError> {
    let mut children = vec![Vec::new(); description.links.len()];
    let mut parent_joint: Vec<Option<usize>> = vec![None; description.links.len()];
    for (j, joint) in description.joints.iter().enumerate() {
        let find = |name: &str| {
            links.get(name).copied().ok_or_else(|| ModelError::UnknownName {
                user: format!("joint `{}`", joint.name),
                sort: "link",
                name: name.into(),
            })
        };
        let (parent, child) = (find(&joint.parent)?, find(&joint.child)?);
        if let Some(first) = parent_joint[child].replace(j) {
            return Err(ModelError::TwoParents {
                link: joint.child.clone(),
                first: description.joints[first].name.clone(),
                second: joint.name.clone(),
            });
        }
        children[parent].push(j);
    }
    let name = |i: &usize| description.links[*i].name.clone();
    let roots: Vec<usize> = (0..description.links.len()).filter(|&i| parent_joint[i].is_none()).collect();
    if roots.len() > 1 {
        return Err(ModelError::SeveralRoots { links: roots.iter().map(name).collect() });
    }
    let mut reached = vec![false; description.links.len()];
    let mut pending = roots.clone();
    while let Some(link) = pending.pop() {
        reached[link] = true;
        pending.extend(children[link].iter().map(|&j| links[description.joints[j].child.as_str()]));
    }
    let missed: Vec<usize> = (0..reached.len()).filter(|&i| !reached[i]).collect();
    if !missed.is_empty() {
        return Err(ModelError::Cycle { links: missed.iter().map(name).collect() });
    }
    Ok(Tree { root: roots[0], children, mimic_joints: Vec::new() })
}

/// Orders leaders before mimic joints; rejects cycles and joints that cannot lead or follow.
pub(super) fn order_mimic_joints(
    description: &RobotDescription,
    joints: &HashMap<&str, usize>,
) -> Result<Vec<usize>, ModelError> {
    let mut order = Vec::new();
    let mut done = vec![false; description.joints.len()];
    for start in 0..description.joints.len() {
        // The chain from this joint up to one that is not a mimic joint (or is already in order).
        let mut chain = Vec::new();
        let mut at = start;
        while let (Some(mimic), false) = (&description.joints[at].mimic, done[at]) {
            let joint = &description.joints[at];
            let bad = |reason| ModelError::BadMimic {
                joint: joint.name.clone(),
                leader: mimic.joint.clone(),
                reason,
            };
            if chain.contains(&at) {
                return Err(bad("the chain of mimic joints closes on itself"));
            }
            chain.push(at);
            let Some(&leader) = joints.get(mimic.joint.as_str()) else {
                let user = format!("the mimic of joint `{}`", joint.name);
                return Err(ModelError::UnknownName { user, sort: "joint", name: mimic.joint.clone() });
            };
            if joint.kind.nv() != 1 {
                return Err(bad("only revolute, continuous, prismatic and helical joints can follow"));
            }
            if description.joints[leader].kind.nv() != 1 {
                return Err(bad("only revolute, continuous, prismatic and helical joints can lead"));
            }
            if !mimic.ratio.is_finite() || !mimic.offset.is_finite() {
                return Err(bad("its ratio and offset must be finite"));
            }
            at = leader;
        }
        for &joint in chain.iter().rev() {
            done[joint] = true;
            order.push(joint);
        }
    }
    Ok(order)
}
