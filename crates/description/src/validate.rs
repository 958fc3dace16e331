//! Checks of a description: names, numbers, and whether its joints form one tree.

use std::collections::HashMap;

use crate::actuated::check_actuated;
use crate::joint::JointDescription;
use crate::joint_kind::JointKind;
use crate::validate_beside::validate_beside;
use crate::{ModelError, Pose, RobotDescription};

/// The tree of the joints.
pub struct Tree {
    /// Index of the root link.
    pub root: usize,
    /// For each link its child joints, in the description's order.
    pub children: Vec<Vec<usize>>,
    /// Mimic joints, leaders before their mimic joints.
    pub followers: Vec<usize>,
}

pub fn validate(description: &RobotDescription) -> Result<Tree, ModelError> {
    if description.links.is_empty() {
        return Err(ModelError::NoLinks);
    }
    for (value, quantity) in description.gravity.iter().zip(["x", "y", "z"]) {
        check(value.is_finite(), "gravity", quantity, *value, "finite")?;
    }
    let links = index_names("link", description.links.iter().map(|link| link.name.as_str()))?;
    let joints = index_names("joint", description.joints.iter().map(|joint| joint.name.as_str()))?;
    let tree = span(description, &links)?;
    for joint in &description.joints {
        check_joint(joint)?;
    }
    let mut frames = links.clone();
    let of_equalities = description.equality_frames();
    for frame in description.frames.iter().chain(&of_equalities) {
        if frames.insert(&frame.name, 0).is_some() {
            return Err(ModelError::DuplicateName { sort: "frame", name: frame.name.clone() });
        }
        let owner = format!("frame `{}`", frame.name);
        if !links.contains_key(frame.link.as_str()) {
            return Err(ModelError::UnknownName { user: owner, sort: "link", name: frame.link.clone() });
        }
        check_pose(&owner, &frame.link_from_frame)?;
    }
    check_actuated(description)?;
    validate_beside(description)?;
    Ok(Tree { followers: order_followers(description, &joints)?, ..tree })
}

pub(super) fn index_names<'a>(
    sort: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<HashMap<&'a str, usize>, ModelError> {
    let mut index = HashMap::new();
    for (i, name) in names.enumerate() {
        if index.insert(name, i).is_some() {
            return Err(ModelError::DuplicateName { sort, name: name.into() });
        }
    }
    Ok(index)
}

/// Checks that there is one root, that every other link is the child of one joint, and that the root reaches
/// every link.
fn span(description: &RobotDescription, links: &HashMap<&str, usize>) -> Result<Tree, ModelError> {
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
    Ok(Tree { root: roots[0], children, followers: Vec::new() })
}

pub(super) fn check(
    ok: bool,
    owner: &str,
    quantity: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), ModelError> {
    if ok { Ok(()) } else { Err(ModelError::BadNumber { owner: owner.into(), quantity, value, expected }) }
}

fn check_joint(joint: &JointDescription) -> Result<(), ModelError> {
    let owner = format!("joint `{}`", joint.name);
    check_pose(&owner, &joint.parent_from_joint)?;
    let axes: &[[f64; 3]] = match &joint.kind {
        JointKind::Revolute { axis }
        | JointKind::Continuous { axis }
        | JointKind::Prismatic { axis }
        | JointKind::Helical { axis, .. }
        | JointKind::Planar { normal: axis } => &[*axis],
        JointKind::Universal { first, second } => &[*first, *second],
        JointKind::Fixed | JointKind::Spherical | JointKind::Floating => &[],
    };
    for axis in axes {
        let norm = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < 1e-9 || !norm.is_finite() {
            return Err(ModelError::ZeroAxis { joint: joint.name.clone(), axis: *axis });
        }
    }
    if let JointKind::Helical { pitch, .. } = joint.kind {
        check(pitch.is_finite(), &owner, "pitch", pitch, "finite")?;
    }
    let passive = &joint.passive;
    for (value, quantity) in [
        (passive.armature, "armature"),
        (passive.damping, "damping"),
        (passive.friction, "friction"),
        (passive.stiffness, "stiffness"),
    ] {
        check(value.is_finite(), &owner, quantity, value, "finite")?;
    }
    check(passive.rest.is_finite(), &owner, "rest position", passive.rest, "finite")?;
    if matches!(joint.kind, JointKind::Spherical | JointKind::Floating) {
        check(
            passive.stiffness == 0.0,
            &owner,
            "stiffness",
            passive.stiffness,
            "zero, as a quaternion joint needs; give it a placement's spring",
        )?;
    }
    let limits = &joint.limits;
    check(!limits.lower.is_nan(), &owner, "lower limit", limits.lower, "a number")?;
    check(!limits.upper.is_nan(), &owner, "upper limit", limits.upper, "a number")?;
    check(limits.velocity >= 0.0, &owner, "velocity limit", limits.velocity, "zero or positive")?;
    check(limits.effort >= 0.0, &owner, "effort limit", limits.effort, "zero or positive")?;
    check(limits.turn >= 0.0, &owner, "largest turn", limits.turn, "zero or positive")
}

/// RᵀR = 1 and det R = 1 up to 1e-6: looser than rounding, but tight enough to detect a wrong matrix.
pub(super) fn check_pose(owner: &str, pose: &Pose) -> Result<(), ModelError> {
    for x in pose.translation {
        check(x.is_finite(), owner, "translation", x, "finite")?;
    }
    let defect = pose.rotation_defect();
    if defect <= 1e-6 { Ok(()) } else { Err(ModelError::NotARotation { owner: owner.into(), defect }) }
}

/// Orders leaders before mimic joints; rejects cycles and joints that cannot lead or follow.
fn order_followers(
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
                return Err(bad("the chain of followers closes on itself"));
            }
            chain.push(at);
            let Some(&leader) = joints.get(mimic.joint.as_str()) else {
                let user = format!("the mimic of joint `{}`", joint.name);
                return Err(ModelError::UnknownName { user, sort: "joint", name: mimic.joint.clone() });
            };
            if !is_single(&joint.kind) {
                return Err(bad("only revolute, continuous, prismatic and helical joints can follow"));
            }
            if !is_single(&description.joints[leader].kind) {
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

pub fn is_single(kind: &JointKind) -> bool {
    matches!(
        kind,
        JointKind::Revolute { .. }
            | JointKind::Continuous { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Helical { .. }
    )
}
