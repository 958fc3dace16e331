//! Reads `<group>` and `<end_effector>`.

use std::collections::{BTreeSet, HashMap};

use robot_dynamics_description::{EndEffectorDescription, GroupDescription};
use robot_dynamics_xml::Resource;

use super::semantics::{Semantics, Sort};
use crate::UrdfError;
use crate::element::Element;
use crate::unread_parts::UnknownPart;

const GROUP_NAME: &str = "name=\"NAME\", the name of a group";

/// The members of a group by index.
#[derive(Default)]
struct Members {
    links: BTreeSet<usize>,
    joints: BTreeSet<usize>,
    chains: Vec<(String, String)>,
    subgroups: Vec<usize>,
}

impl<'a> Semantics<'a, '_> {
    pub(super) fn groups(&mut self, root: &Element<'a>) {
        let elements = self.elements(root, "group");
        let mut names = Vec::with_capacity(elements.len());
        for (at, element) in elements.iter().enumerate() {
            let name = self.reader.required_name(element, "name", GROUP_NAME);
            if let Some(first) = self.group_indices.insert(name, at).filter(|_| !name.is_empty()) {
                let (line, first) = (element.line, elements[first].line);
                let name = name.to_owned();
                self.reader.refuse(UrdfError::DuplicateName { line, what: "group", name, first });
            }
            names.push(name);
        }
        let mut groups: Vec<Members> = Vec::with_capacity(elements.len());
        for element in &elements {
            let members = self.members(element);
            groups.push(members);
        }
        self.unite(&elements, &names, &mut groups);
        let described: Vec<GroupDescription> = groups
            .into_iter()
            .zip(&names)
            .map(|(members, name)| {
                let links = members.links.iter().map(|&link| self.robot.links[link].name.as_str());
                let joints = members.joints.iter().map(|&joint| self.robot.joints[joint].name.as_str());
                let mut group = GroupDescription::new(*name, links, joints);
                group.chains = members.chains;
                group.subgroups = members.subgroups.iter().map(|&at| names[at].to_owned()).collect();
                group
            })
            .collect();
        self.robot.groups.extend(described);
    }

    /// The members that a group lists itself.
    fn members(&mut self, element: &Element<'a>) -> Members {
        let mut members = Members::default();
        let parts = ["link", "joint", "chain", "group"];
        self.reader.list_unread(element, &["name"], &parts, UnknownPart::Harmless);
        for link in self.elements(element, "link") {
            self.reader.list_unread(&link, &["name"], &[], UnknownPart::Harmless);
            let name = self.reader.required_name(&link, "name", "name=\"NAME\", the name of a link");
            let Some(index) = self.find(&link, Sort::Link, name) else { continue };
            members.links.insert(index);
            members.joints.extend(self.joint_above[index]);
        }
        for joint in self.elements(element, "joint") {
            self.reader.list_unread(&joint, &["name"], &[], UnknownPart::Harmless);
            let name = self.reader.required_name(&joint, "name", "name=\"NAME\", the name of a joint");
            let index = self.joint_index(&joint, name).flatten();
            members.joints.extend(index);
        }
        for chain in self.elements(element, "chain") {
            self.reader.list_unread(&chain, &["base_link", "tip_link"], &[], UnknownPart::Harmless);
            let [base, tip] = ["base_link", "tip_link"].map(|attribute| {
                self.reader.required_name(&chain, attribute, "base_link=\"NAME\" tip_link=\"NAME\"")
            });
            let ends = [base, tip].map(|name| self.find(&chain, Sort::Link, name));
            if let [Some(from), Some(to)] = ends {
                let joints = self.path(&chain, from, to);
                members.joints.extend(joints);
                members.chains.push((base.to_owned(), tip.to_owned()));
            }
        }
        for group in self.elements(element, "group") {
            self.reader.list_unread(&group, &["name"], &[], UnknownPart::Harmless);
            let name = self.reader.required_name(&group, "name", GROUP_NAME);
            members.subgroups.extend(self.find(&group, Sort::Group, name));
        }
        let children =
            members.joints.iter().filter_map(|&joint| self.links.get(&self.robot.joints[joint].child));
        members.links.extend(children);
        members
    }

    /// The index of a joint. `Some(None)` is a fixed virtual joint, which the robot does not have.
    #[allow(clippy::option_option)] // an unknown joint, a joint that the robot lacks, and a joint
    pub(super) fn joint_index(&mut self, element: &Element<'a>, name: &str) -> Option<Option<usize>> {
        match self.virtual_names.get(name) {
            Some(None) => Some(None),
            Some(Some(own)) => Some(self.joints.get(own).copied()),
            None => self.find(element, Sort::Joint, name).map(Some),
        }
    }

    /// The joints between two links: down from the link above both.
    fn path(&mut self, element: &Element<'a>, base: usize, tip: usize) -> Vec<usize> {
        // For each link above the tip the number of joints between.
        let (mut joints, mut passed) = (Vec::new(), HashMap::new());
        let mut link = tip;
        while link != base && self.charge(element, Resource::Steps, 1) {
            passed.insert(link, joints.len());
            let Some(parent) = self.go_up(link, &mut joints) else { break };
            link = parent;
        }
        passed.insert(link, joints.len());
        let (mut others, mut link) = (Vec::new(), base);
        loop {
            if let Some(&count) = passed.get(&link) {
                joints.truncate(count);
                joints.append(&mut others);
                return joints;
            }
            if !self.charge(element, Resource::Steps, 1) {
                return joints;
            }
            let Some(parent) = self.go_up(link, &mut others) else { return joints };
            link = parent;
        }
    }

    /// The parent of a link. Adds the joint between to the list.
    fn go_up(&self, link: usize, joints: &mut Vec<usize>) -> Option<usize> {
        let joint = self.joint_above[link]?;
        joints.push(joint);
        self.links.get(&self.robot.joints[joint].parent).copied()
    }

    /// Adds the members of subgroups to each group, those without subgroups first.
    fn unite(&mut self, elements: &[Element<'a>], names: &[&str], groups: &mut [Members]) {
        let mut users = vec![Vec::new(); groups.len()];
        let mut missing: Vec<usize> = groups.iter().map(|group| group.subgroups.len()).collect();
        for (at, group) in groups.iter().enumerate() {
            for &part in &group.subgroups {
                users[part].push(at);
            }
        }
        let mut complete: Vec<usize> = (0..groups.len()).filter(|&at| missing[at] == 0).collect();
        let mut next = 0;
        while let Some(&part) = complete.get(next) {
            next += 1;
            for &user in &users[part] {
                let members = core::mem::take(&mut groups[part]);
                let count = members.links.len() + members.joints.len();
                if self.charge(&elements[user], Resource::Elements, count + 1) {
                    groups[user].links.extend(&members.links);
                    groups[user].joints.extend(&members.joints);
                }
                groups[part] = members;
                missing[user] -= 1;
                if missing[user] == 0 {
                    complete.push(user);
                }
            }
        }
        if let Some(first) = (0..groups.len()).find(|&at| missing[at] > 0) {
            let others = (0..groups.len()).filter(|&at| missing[at] > 0).take(10);
            let listed: Vec<String> = others.map(|at| format!("{:?}", names[at])).collect();
            let reason = format!(
                "the groups {} contain each other; remove one of them from the other",
                listed.join(", ")
            );
            self.refuse(&elements[first], reason);
        }
    }

    pub(super) fn end_effectors(&mut self, root: &Element<'a>) {
        let mut lines = HashMap::new();
        for element in self.elements(root, "end_effector") {
            let known = ["name", "parent_link", "group", "parent_group"];
            self.reader.list_unread(&element, &known, &[], UnknownPart::Harmless);
            let [name, link, group] = ["name", "parent_link", "group"].map(|attribute| {
                self.reader.required_name(&element, attribute, &format!("{attribute}=\"NAME\""))
            });
            if let Some(first) = lines.insert(name, element.line).filter(|_| !name.is_empty()) {
                let (line, name) = (element.line, name.to_owned());
                self.reader.refuse(UrdfError::DuplicateName { line, what: "end effector", name, first });
            }
            self.find(&element, Sort::Link, link);
            self.find(&element, Sort::Group, group);
            let parent_group = element.text("parent_group").filter(|name| !name.is_empty());
            if let Some(name) = parent_group {
                self.find(&element, Sort::Group, name);
            }
            let mut tool = EndEffectorDescription::new(name, group, link);
            tool.parent_group = parent_group.map(str::to_owned);
            self.robot.end_effectors.push(tool);
        }
    }
}
