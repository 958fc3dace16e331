//! Reads `<group_state>`: named poses.

use std::collections::{HashMap, HashSet};

use robot_dynamics_description::{JointKind, NamedPose};
use robot_dynamics_xml::excerpt;

use super::semantics::{Semantics, Sort};
use crate::UrdfError;
use crate::element::Element;
use crate::unread_parts::UnknownPart;

impl<'a> Semantics<'a, '_> {
    pub(super) fn group_states(&mut self, root: &Element<'a>) {
        let elements = self.elements(root, "group_state");
        let mut groups_of: HashMap<&str, HashSet<&str>> = HashMap::new();
        for element in &elements {
            let groups = groups_of.entry(element.text("name").unwrap_or_default()).or_default();
            groups.insert(element.text("group").unwrap_or_default());
        }
        let mut taken: HashMap<String, usize> =
            self.robot.poses.iter().map(|pose| (pose.name.clone(), 0)).collect();
        for element in &elements {
            self.reader.list_unread(element, &["name", "group"], &["joint"], UnknownPart::Harmless);
            let name = self.reader.required_name(element, "name", "name=\"NAME\"");
            let group = self.reader.required_name(element, "group", "group=\"NAME\"");
            let index = self.find(element, Sort::Group, group);
            let is_shared = groups_of.get(name).is_some_and(|groups| groups.len() > 1);
            let full = if is_shared { format!("{group}/{name}") } else { name.to_owned() };
            if is_shared {
                let message =
                    format!("several groups have a state {:?}: the pose is named {full:?}", excerpt(name));
                self.reader.report_default(element, message);
            }
            if let Some(first) = taken.insert(full.clone(), element.line).filter(|_| !name.is_empty()) {
                self.refuse_second(element, &full, first);
            }
            let mut pose = NamedPose::new(full, []);
            pose.group = Some(group.to_owned());
            let mut placed = HashSet::new();
            for joint in self.elements(element, "joint") {
                if let Some((name, position)) = self.position(&joint, index) {
                    if placed.insert(name.clone()) {
                        pose.positions.push((name, position));
                    } else {
                        self.reader
                            .warn(&joint, "a second position of this joint; the first counts; delete one");
                    }
                }
            }
            self.reader.report_read(element, format!("a pose of {} joints", pose.positions.len()));
            self.robot.poses.push(pose);
        }
    }

    fn refuse_second(&mut self, element: &Element<'a>, name: &str, first: usize) {
        let (line, name) = (element.line, excerpt(name));
        if first > 0 {
            self.reader.refuse(UrdfError::DuplicateName { line, what: "group state", name, first });
        } else {
            let reason = format!("the robot's file already has a pose {name:?}; rename the state");
            self.refuse(element, reason);
        }
    }

    /// The name of a joint with its part of q.
    fn position(&mut self, element: &Element<'a>, group: Option<usize>) -> Option<(String, Vec<f64>)> {
        self.reader.list_unread(element, &["name", "value"], &[], UnknownPart::Harmless);
        let name = self.reader.required_name(element, "name", "name=\"NAME\", the name of a joint");
        let text = self.reader.required_text(element, "value", "value=\"NUMBER\"")?;
        let mut position = self.reader.list(element, "value", text)?;
        let (own_name, kind, is_mimic) = match self.joint_index(element, name)? {
            Some(joint) => {
                let own = &self.robot.joints[joint];
                (own.name.clone(), own.kind, own.mimic.is_some())
            }
            // The joint of a floating base is not among the joints.
            None => match self.virtual_names.get(name) {
                Some(Some(base)) => (base.clone(), JointKind::Floating, false),
                _ => (name.to_owned(), JointKind::Fixed, false),
            },
        };
        let expected = kind.nq();
        if let Some(group) = group.and_then(|group| self.robot.groups.get(group))
            && kind != JointKind::Fixed
            && self.joints.contains_key(&own_name)
            && !group.joints.contains(&own_name)
        {
            let message = format!(
                "the group {:?} does not contain this joint: its position is kept",
                excerpt(&group.name)
            );
            self.reader.warn(element, message);
        }
        if expected == 0 || is_mimic {
            let reason = if is_mimic { "it follows another joint" } else { "it is fixed" };
            let message = format!("the position of this joint is not used: {reason}");
            self.reader.report_ignored(element.line, element.place.clone(), message);
            return None;
        }
        if position.len() != expected {
            let (line, place, text) = (element.line, element.place.clone(), excerpt(text));
            let (attribute, found) = ("value".to_owned(), position.len());
            self.reader.refuse(UrdfError::WrongCount { line, place, attribute, text, expected, found });
            return None;
        }
        if expected > kind.nv() {
            let quaternion = &mut position[expected - 4..];
            let norm = quaternion.iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
            // The squares of smaller numbers underflow.
            if norm < 1e-100 {
                self.refuse(element, "the quaternion is zero; write 0 0 0 1 for no rotation".to_owned());
                return None;
            }
            for x in quaternion.iter_mut() {
                *x /= norm;
            }
        }
        Some((own_name, position))
    }
}
