//! Checks of a description: names, numbers, and whether its joints form one tree.

mod actuators;
mod checks;
mod equalities;
mod fluid;
mod groups;
mod joints;
mod names;
mod sensors;
mod tendons;
mod tree;

use self::actuators::check_actuators;
pub(crate) use self::actuators::check_motor;
pub(crate) use self::checks::check_pose;
use self::checks::{check, index_names};
use self::equalities::check_equalities;
use self::fluid::check_fluid;
use self::groups::check_groups;
pub(crate) use self::joints::check_joint;
use self::joints::check_joint_forces;
use self::names::Names;
use self::sensors::check_sensors;
use self::tendons::check_tendons;
pub use self::tree::Tree;
use self::tree::{order_mimic_joints, span};
use crate::actuated_joints::check_actuated;
use crate::{ModelError, RobotDescription};

/// Checks a description and returns its tree.
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
    description.joints.iter().try_for_each(check_joint)?;
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
    for link in &description.links {
        let (owner, value) = (format!("link `{}`", link.name), link.gravity_compensation);
        check(value.is_finite(), &owner, "gravity compensation", value, "finite")?;
    }
    description.joints.iter().try_for_each(check_joint_forces)?;
    let names = Names::new(description);
    check_tendons(description, &names)?;
    check_fluid(description, &links)?;
    check_equalities(description, &names)?;
    check_actuators(description, &names)?;
    check_sensors(description, &names)?;
    check_groups(description, &names)?;
    Ok(Tree { mimic_joints: order_mimic_joints(description, &joints)?, ..tree })
}
