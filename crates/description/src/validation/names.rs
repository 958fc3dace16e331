//! The links and joints of a description by name.

use std::collections::HashMap;

use super::checks::unknown;
use crate::{JointDescription, JointKind, LinkDescription, ModelError, RobotDescription};

/// The names that can be referred to.
pub(super) struct Names<'a> {
    pub(super) links: HashMap<&'a str, &'a LinkDescription>,
    pub(super) joints: HashMap<&'a str, &'a JointDescription>,
}

impl<'a> Names<'a> {
    /// The names of a robot's links and joints.
    pub(super) fn new(description: &'a RobotDescription) -> Self {
        Self {
            links: description.links.iter().map(|link| (link.name.as_str(), link)).collect(),
            joints: description.joints.iter().map(|joint| (joint.name.as_str(), joint)).collect(),
        }
    }
}

impl Names<'_> {
    /// Rejects an unknown link.
    pub(super) fn link(&self, user: &str, name: &str) -> Result<(), ModelError> {
        let found = self.links.contains_key(name);
        if found { Ok(()) } else { Err(unknown(user, "link", name)) }
    }

    /// Rejects all but a joint of one DoF and a locked one.
    pub(super) fn single_joint(&self, user: &str, name: &str) -> Result<(), ModelError> {
        let joint = self.joints.get(name).ok_or_else(|| unknown(user, "joint", name))?;
        if joint.kind.nv() == 1 || joint.kind == JointKind::Fixed {
            return Ok(());
        }
        Err(ModelError::UnknownName {
            user: user.into(),
            sort: "joint of one degree of freedom",
            name: name.into(),
        })
    }
}
