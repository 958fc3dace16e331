//! Checks of the groups and end effectors of a description.

use super::checks::{index_names, unknown};
use super::names::Names;
use crate::{ModelError, RobotDescription};

pub(super) fn check_groups(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    let groups = index_names("group", description.groups.iter().map(|group| group.name.as_str()))?;
    let known = |user: &str, name: &str| {
        if groups.contains_key(name) { Ok(()) } else { Err(unknown(user, "group", name)) }
    };
    for group in &description.groups {
        let user = format!("group `{}`", group.name);
        let ends = group.chains.iter().flat_map(|(base, tip)| [base, tip]);
        group.links.iter().chain(ends).try_for_each(|link| names.link(&user, link))?;
        if let Some(joint) = group.joints.iter().find(|joint| !names.joints.contains_key(joint.as_str())) {
            return Err(unknown(&user, "joint", joint));
        }
        group.subgroups.iter().try_for_each(|name| known(&user, name))?;
    }
    index_names("end effector", description.end_effectors.iter().map(|tool| tool.name.as_str()))?;
    for tool in &description.end_effectors {
        let user = format!("end effector `{}`", tool.name);
        names.link(&user, &tool.parent_link)?;
        known(&user, &tool.group)?;
        tool.parent_group.iter().try_for_each(|name| known(&user, name))?;
    }
    Ok(())
}
