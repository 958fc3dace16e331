//! The state of adding one SRDF file to a robot.

use std::collections::{HashMap, HashSet};

use robot_dynamics_description::{Disposition, JointKind, LoadReport, RobotDescription, similar};
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Budget, ExceededLimit, Resource, excerpt};

use super::pairs::collision_pairs;
use crate::element::Element;
use crate::reader::Reader;
use crate::{LoadError, UrdfError};

/// The number of errors that suggest a name, which takes time in proportion to the robot.
const SUGGESTIONS: usize = 20;

/// The kind of object that a name refers to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    Link,
    Joint,
    Group,
}

/// Adds the elements of one SRDF file to a robot.
pub(super) struct Semantics<'a, 'r> {
    pub(super) reader: Reader<'a>,
    pub(super) robot: &'r mut RobotDescription,
    pub(super) links: HashMap<String, usize>,
    pub(super) joints: HashMap<String, usize>,
    /// For each link the joint whose child it is.
    pub(super) joint_above: Vec<Option<usize>>,
    /// The groups of the file by name.
    pub(super) group_indices: HashMap<&'a str, usize>,
    /// The virtual joints by name, with the name of their joint in the robot; `None` for a fixed one.
    pub(super) virtual_names: HashMap<&'a str, Option<String>>,
    /// Joints without a motor.
    pub(super) passive: HashSet<String>,
    budget: Budget,
    suggestions: usize,
}

impl<'a, 'r> Semantics<'a, 'r> {
    pub(super) fn new(reader: Reader<'a>, robot: &'r mut RobotDescription) -> Self {
        let mut semantics = Self {
            reader,
            robot,
            links: HashMap::new(),
            joints: HashMap::new(),
            joint_above: Vec::new(),
            group_indices: HashMap::new(),
            virtual_names: HashMap::new(),
            passive: HashSet::new(),
            budget: Budget::default(),
            suggestions: SUGGESTIONS,
        };
        semantics.index_robot();
        semantics
    }

    /// Updates the indices of links and joints.
    pub(super) fn index_robot(&mut self) {
        let RobotDescription { links, joints, .. } = &*self.robot;
        self.links = links.iter().enumerate().map(|(at, link)| (link.name.clone(), at)).collect();
        self.joints = joints.iter().enumerate().map(|(at, joint)| (joint.name.clone(), at)).collect();
        self.joint_above = vec![None; links.len()];
        for (at, joint) in joints.iter().enumerate() {
            if let Some(&child) = self.links.get(&joint.child) {
                self.joint_above[child] = Some(at);
            }
        }
    }

    /// The elements of this name in an element.
    pub(super) fn elements(&self, parent: &Element<'a>, name: &'static str) -> Vec<Element<'a>> {
        let own = |node: &Node<'a, 'a>| self.reader.is(*node, name);
        parent.node.children().filter(own).map(|node| self.reader.named_element(node, name)).collect()
    }

    /// A note if the file names another robot.
    pub(super) fn note_name(&mut self, root: &Element<'a>) {
        let Some(name) = root.text("name").filter(|name| *name != self.robot.name) else { return };
        let message = format!(
            "the file names the robot {:?}: it is added to {:?}",
            excerpt(name),
            excerpt(&self.robot.name)
        );
        self.reader.report_ignored(root.line, root.place.clone(), message);
    }

    /// The index of a link, joint or group; `None`, with an error, for an unknown one. An empty name has its
    /// own error.
    pub(super) fn find(&mut self, element: &Element<'a>, sort: Sort, name: &str) -> Option<usize> {
        let found = match sort {
            Sort::Link => self.links.get(name).copied(),
            Sort::Joint => self.joints.get(name).copied(),
            Sort::Group => self.group_indices.get(name).copied(),
        };
        if found.is_none() && !name.is_empty() {
            self.refuse_unknown(element, sort, name);
        }
        found
    }

    fn refuse_unknown(&mut self, element: &Element<'a>, sort: Sort, name: &str) {
        let near = if self.suggestions > 0 {
            self.suggestions -= 1;
            match sort {
                Sort::Link => similar(name, self.robot.links.iter().map(|link| link.name.as_str())),
                Sort::Joint => similar(name, self.robot.joints.iter().map(|joint| joint.name.as_str())),
                Sort::Group => similar(name, self.group_indices.keys().copied()),
            }
        } else {
            None
        };
        let (line, place, name) = (element.line, element.place.clone(), excerpt(name));
        let near = near.map_or_else(
            || "correct the name".to_owned(),
            |near| format!("did you mean `{}`?", excerpt(&near)),
        );
        let (owner, what) = match sort {
            Sort::Link => ("the robot", "link"),
            Sort::Joint => ("the robot", "joint"),
            Sort::Group => ("the file", "group"),
        };
        self.reader.refuse(UrdfError::UnknownName { line, place, owner, what, name, near });
    }

    /// Lists an error; reading continues.
    pub(super) fn refuse(&mut self, element: &Element<'a>, reason: String) {
        let (line, place) = (element.line, element.place.clone());
        self.reader.refuse(UrdfError::BadSemantics { line, place, reason });
    }

    /// Charges the budget; `false`, with an error, above the limit.
    pub(super) fn charge(&mut self, element: &Element<'a>, resource: Resource, count: usize) -> bool {
        let is_first = !self.budget.is_exceeded();
        let Err(ExceededLimit { what, limit }) = self.budget.charge(resource, count) else { return true };
        if is_first {
            self.reader.refuse(UrdfError::TooMany { line: element.line, what, limit });
        }
        false
    }

    /// Adds the pairs of links that never touch.
    pub(super) fn collisions(&mut self, root: &Element<'a>) {
        let links: Vec<&str> = self.robot.links.iter().map(|link| link.name.as_str()).collect();
        let found = collision_pairs(&mut self.reader, &mut self.budget, root, &links);
        for (element, name) in &found.names {
            self.find(element, Sort::Link, name);
        }
        let excluded = &mut self.robot.contact_exclusions;
        let known: HashSet<(String, String)> = excluded.iter().cloned().collect();
        let is_new = |(a, b): &(String, String)| {
            let [one, other] = [(a.clone(), b.clone()), (b.clone(), a.clone())];
            !known.contains(&one) && !known.contains(&other)
        };
        let added: Vec<_> = found.pairs.into_iter().filter(is_new).collect();
        if !added.is_empty() {
            let message = format!("{} pairs of links never touch", added.len());
            self.reader.report_read(root, message);
        }
        excluded.extend(added);
    }

    /// Sets the actuated joints, and returns the report of the file.
    pub(super) fn finish(mut self) -> Result<LoadReport, LoadError> {
        if !self.passive.is_empty() {
            let has_motor = |joint: &&robot_dynamics_description::JointDescription| {
                joint.kind.nv() > 0 && joint.kind != JointKind::Floating && joint.mimic.is_none()
            };
            let joints = self.robot.joints.iter().filter(has_motor).map(|joint| joint.name.clone());
            let actuated = self.robot.actuated_joints.take().unwrap_or_else(|| joints.collect());
            let actuated = actuated.into_iter().filter(|joint| !self.passive.contains(joint)).collect();
            self.robot.actuated_joints = Some(actuated);
        }
        let mut report = core::mem::take(&mut self.reader.report);
        report.sort();
        let mut errors = self.reader.errors;
        errors.append(&mut self.reader.refused_warnings);
        if errors.is_empty() { Ok(report) } else { Err(LoadError::new(errors, UrdfError::sorted_at, report)) }
    }
}

impl Reader<'_> {
    /// Reports markup that was repaired.
    pub(super) fn push_fault(&mut self, line: usize, message: &str) {
        self.push(line, "robot".into(), Disposition::AsWritten, message.to_owned());
    }
}
