//! Reads `<virtual_joint>`, `<passive_joint>` and `<rotor_params>`.

use std::collections::HashSet;

use robot_dynamics_description::{Base, JointDescription, JointKind, LinkDescription, Pose};
use robot_dynamics_xml::excerpt;

use super::semantics::{Semantics, Sort};
use crate::element::Element;
use crate::unread_parts::UnknownPart;

impl<'a> Semantics<'a, '_> {
    /// Adds the joints between the world and the robot.
    pub(super) fn virtual_joints(&mut self, root: &Element<'a>) {
        for element in self.elements(root, "virtual_joint") {
            let known = ["name", "type", "parent_frame", "child_link"];
            self.reader.list_unread(&element, &known, &[], UnknownPart::Harmless);
            let [name, kind, frame, child] = known.map(|attribute| {
                self.reader.required_name(&element, attribute, &format!("{attribute}=\"…\""))
            });
            let found = self.find(&element, Sort::Link, child);
            let kind = match kind {
                "fixed" | "" => JointKind::Fixed,
                "floating" => JointKind::Floating,
                "planar" => JointKind::Planar { normal: [0.0, 0.0, 1.0] },
                other => {
                    let reason =
                        format!("the type {:?} is unknown; use fixed, floating or planar", excerpt(other));
                    self.refuse(&element, reason);
                    continue;
                }
            };
            if let Some(child) = found {
                let own = self.virtual_joint(&element, name, kind, frame, child);
                self.virtual_names.insert(name, own);
            }
        }
    }

    /// The name of the joint in the robot; `None` for a fixed joint and, with an error, for one
    /// that does not fit the robot.
    fn virtual_joint(
        &mut self,
        element: &Element<'a>,
        name: &str,
        kind: JointKind,
        frame: &str,
        child: usize,
    ) -> Option<String> {
        if kind == JointKind::Fixed {
            let message = "fixed: the robot keeps its place in the world";
            self.reader.report_read(element, message);
            return None;
        }
        if self.joint_above[child].is_some() {
            let reason = format!(
                "its child link {:?} is not the root of the robot, and has a parent joint; name the root link",
                excerpt(&self.robot.links[child].name)
            );
            self.refuse(element, reason);
            return None;
        }
        if self.robot.base == Base::Floating || self.robot.root_floats() {
            if kind != JointKind::Floating {
                let reason =
                    "the base of the robot already floats; load it without a floating base".to_owned();
                self.refuse(element, reason);
                return None;
            }
            let message = "the base of the robot already floats: no joint is added";
            self.reader.report_ignored(element.line, element.place.clone(), message);
            return (self.robot.base == Base::Floating).then(|| self.robot.floating_base_name());
        }
        if self.joints.contains_key(name) {
            self.refuse(element, "a joint of the robot has this name; rename the virtual joint".to_owned());
            return None;
        }
        let mut parent = frame.to_owned();
        let frames: HashSet<&str> = self.robot.frames.iter().map(|frame| frame.name.as_str()).collect();
        while self.links.contains_key(&parent) || frames.contains(parent.as_str()) {
            parent.push('_');
        }
        let message = format!(
            "a {} joint from the new root link {:?} to {:?}",
            kind.name(),
            excerpt(&parent),
            excerpt(&self.robot.links[child].name)
        );
        self.reader.report_read(element, message);
        let child = self.robot.links[child].name.clone();
        self.robot.links.insert(0, LinkDescription::new(&parent, None));
        self.robot.joints.insert(0, JointDescription::new(name, kind, parent, child, Pose::IDENTITY));
        if kind != JointKind::Floating {
            self.passive.insert(name.to_owned());
        }
        self.index_robot();
        Some(name.to_owned())
    }

    /// Reads the joints without a motor.
    pub(super) fn passive_joints(&mut self, root: &Element<'a>) {
        for element in self.elements(root, "passive_joint") {
            self.reader.list_unread(&element, &["name"], &[], UnknownPart::Harmless);
            let name = self.reader.required_name(&element, "name", "name=\"NAME\", the name of a joint");
            let Some(Some(index)) = self.joint_index(&element, name) else { continue };
            let joint = &self.robot.joints[index];
            if joint.kind == JointKind::Fixed || joint.mimic.is_some() {
                let message = "passive without effect: the joint has no motion of its own";
                self.reader.report_ignored(element.line, element.place.clone(), message);
            } else {
                self.passive.insert(joint.name.clone());
                self.reader.report_read(&element, "a joint without a motor");
            }
        }
    }

    /// Adds the reflected inertias of motors to the armatures of their joints.
    pub(super) fn rotors(&mut self, root: &Element<'a>) {
        for list in self.elements(root, "rotor_params") {
            self.reader.list_unread(&list, &[], &["joint"], UnknownPart::Physics);
            for element in self.elements(&list, "joint") {
                let known = ["name", "mass", "gear_ratio"];
                self.reader.list_unread(&element, &known, &[], UnknownPart::Physics);
                let name = self.reader.required_name(&element, "name", "name=\"NAME\", the name of a joint");
                let inertia = self.reader.required_number(&element, "mass");
                let ratio = self.reader.number(&element, "gear_ratio").unwrap_or(1.0);
                let Some(Some(index)) = self.joint_index(&element, name) else { continue };
                let value = ratio * ratio * inertia;
                if self.robot.joints[index].kind == JointKind::Fixed {
                    let (line, place) = (element.line, element.place.clone());
                    self.reader.report_ignored(line, place, "a fixed joint has no rotor");
                    continue;
                }
                self.robot.joints[index].passive.armature += value;
                let message = format!("the reflected inertia {value} is added to the armature of the joint");
                self.reader.report_read(&element, message);
            }
        }
    }
}
