//! Reads `<joint>`: type, placement, axis.

use robot_dynamics_description::{JointDescription, JointKind};
use robot_dynamics_xml::excerpt;

use crate::UrdfError;
use crate::drake::is_drake;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The squares of shorter axes underflow in double precision.
const SHORTEST_AXIS: f64 = 1e-100;

/// The axis of a joint without `<axis>`.
const DEFAULT_AXIS: [f64; 3] = [1.0, 0.0, 0.0];

impl<'a> Reader<'a> {
    /// Reads a joint. A missing name or type is listed as an error, and reading continues with an empty name
    /// or the type `continuous`.
    pub(crate) fn joint(&mut self, element: &Element<'a>) -> JointDescription {
        let name = self.required_name(element, "name", "<joint name=\"NAME\" type=\"TYPE\">");
        let type_name = self.required_text(element, "type", "type=\"revolute\" or another joint type");
        let of_drake = is_drake(element.node, "joint");
        let drake_kind =
            type_name.filter(|_| of_drake).and_then(|kind| self.drake_joint(element, name, kind));
        let passive = self.passive_forces_element(element);
        let known = ["origin", "parent", "child", "axis", "limit", "dynamics", passive, "mimic"];
        self.list_unread(element, &["name", "type"], &known, UnknownPart::Physics);
        let (parent, child) = (self.link_of(element, "parent"), self.link_of(element, "child"));
        let parent_from_joint = self.origin(element);
        let kind = match drake_kind {
            Some(kind) => kind,
            None => self.joint_kind(element, name, type_name.unwrap_or("continuous")),
        };
        let has_axis = match kind {
            JointKind::Fixed | JointKind::Floating | JointKind::Spherical => false,
            JointKind::Universal { .. } | JointKind::Planar { .. } => !of_drake,
            _ => true,
        };
        if !has_axis {
            self.report_unused(element, kind, "axis");
        }
        let mut joint = JointDescription::new(name, kind, parent, child, parent_from_joint);
        if kind == JointKind::Fixed {
            for part in ["limit", passive, "mimic"] {
                self.report_unused(element, kind, part);
            }
        } else {
            joint.limits = self.limits(element, kind);
            joint.passive = self.passive_forces(element, passive, kind);
            joint.mimic = self.mimic(element);
        }
        self.report_read(
            element,
            format!("{} joint from {:?} to {:?}", kind.name(), excerpt(parent), excerpt(child)),
        );
        joint
    }

    /// The kind of joint of this type.
    fn joint_kind(&mut self, element: &Element<'a>, name: &str, type_name: &str) -> JointKind {
        match type_name {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute { axis: self.axis(element, name) },
            "continuous" => JointKind::Continuous { axis: self.axis(element, name) },
            "prismatic" => JointKind::Prismatic { axis: self.axis(element, name) },
            "planar" => JointKind::Planar { normal: self.axis(element, name) },
            "floating" => JointKind::Floating,
            "spherical" | "ball" => JointKind::Spherical,
            other => {
                self.refuse(UrdfError::UnknownJointType {
                    line: element.line,
                    joint: excerpt(name),
                    found: excerpt(other),
                });
                JointKind::Continuous { axis: self.axis(element, name) }
            }
        }
    }

    fn link_of(&mut self, joint: &Element<'a>, role: &'static str) -> &'a str {
        let advice = "write <parent link=\"NAME\"/> and <child link=\"NAME\"/>";
        let Some(element) = self.required_child(joint, role, advice) else { return "" };
        self.list_unread(&element, &["link"], &[], UnknownPart::Physics);
        self.required_name(&element, "link", "link=\"NAME\"")
    }

    /// The axis in the joint's frame, as written; (1, 0, 0) by default.
    pub(crate) fn axis(&mut self, joint: &Element<'a>, name: &str) -> [f64; 3] {
        let Some(element) = self.child(joint, "axis") else {
            self.report_default(joint, "no <axis>: taken as xyz=\"1 0 0\"");
            return DEFAULT_AXIS;
        };
        self.list_unread(&element, &["xyz"], &[], UnknownPart::Physics);
        let Some(_) = self.required_text(&element, "xyz", "xyz=\"0 0 1\" or another direction") else {
            return DEFAULT_AXIS;
        };
        let axis = self.numbers::<3>(&element, "xyz").unwrap_or(DEFAULT_AXIS);
        if axis.iter().all(|c| c.abs() < SHORTEST_AXIS) {
            self.refuse(UrdfError::ZeroAxis { line: element.line, joint: excerpt(name) });
        }
        self.report_read(&element, "direction");
        axis
    }

    /// Reports a child element that has no meaning for a joint of this kind.
    fn report_unused(&mut self, joint: &Element<'a>, kind: JointKind, name: &'static str) {
        if let Some(element) = self.child(joint, name) {
            self.report_ignored(
                element.line,
                element.place,
                format!("a {} joint has no <{name}>", kind.name()),
            );
        }
    }
}
