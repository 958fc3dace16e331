//! Looks links and joints up by name.

use robot_dynamics_number::InvalidInput;

use crate::error::similar;
use crate::{ModelError, RobotDescription, unknown_name};

impl RobotDescription {
    pub(crate) fn joint_index(&self, name: &str) -> Result<usize, ModelError> {
        let index = self.joints.iter().position(|joint| joint.name == name);
        Ok(index.ok_or_else(|| self.no_joint(name))?)
    }

    pub(super) fn link_index(&self, name: &str) -> Result<usize, ModelError> {
        let index = self.links.iter().position(|link| link.name == name);
        Ok(index.ok_or_else(|| missing("link", name, self.links.iter().map(|link| link.name.as_str())))?)
    }

    /// The error for a missing joint.
    pub(crate) fn no_joint(&self, name: &str) -> InvalidInput {
        missing("joint", name, self.joints.iter().map(|joint| joint.name.as_str()))
    }
}

/// The error for a missing name: the most similar name, or a list of names.
pub(super) fn missing<'a>(
    sort: &str,
    name: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> InvalidInput {
    match similar(name, names.clone()) {
        Some(_) => unknown_name(sort, name, "the robot", names),
        None => InvalidInput::unknown_name(sort, name, "the robot", names),
    }
}
