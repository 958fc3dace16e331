//! `<joint>`: type, place, axis.

use multibody::{JointDescription, JointKind};

use crate::UrdfError;
use crate::element::Element;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::unread::Unknown;

/// Shorter axes have no direction left in double precision once squared.
const SHORTEST_AXIS: f64 = 1e-100;

impl<'a> Reader<'a> {
    /// The joint with everything that its element says.
    pub(crate) fn joint(&mut self, element: &Element<'a>) -> Result<JointDescription, UrdfError> {
        let name = element.required_name("name", "<joint name=\"NAME\" type=\"TYPE\">")?;
        let type_name = element.required_text("type", "type=\"revolute\" or another joint type")?;
        let known = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];
        self.list_unread(element, &["name", "type"], &known, Unknown::IsPhysics)?;
        let parent = self.link_of(element, "parent")?;
        let child = self.link_of(element, "child")?;
        let parent_from_joint = self.origin(element)?;
        let kind = match type_name {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute { axis: self.axis(element, name)? },
            "continuous" => JointKind::Continuous { axis: self.axis(element, name)? },
            "prismatic" => JointKind::Prismatic { axis: self.axis(element, name)? },
            "planar" => JointKind::Planar { normal: self.axis(element, name)? },
            "floating" => JointKind::Floating,
            "spherical" | "ball" => JointKind::Spherical,
            other => {
                return Err(UrdfError::UnknownJointType {
                    line: element.line,
                    joint: excerpt(name),
                    found: excerpt(other),
                });
            }
        };
        if matches!(kind, JointKind::Fixed | JointKind::Floating | JointKind::Spherical) {
            self.without_motion(element, kind, "axis")?;
        }
        let mut joint = JointDescription::new(name, kind, parent, child, parent_from_joint);
        if kind == JointKind::Fixed {
            self.without_motion(element, kind, "limit")?;
            self.without_motion(element, kind, "dynamics")?;
            self.without_motion(element, kind, "mimic")?;
        } else {
            joint.limits = self.limits(element, &joint)?;
            joint.passive = self.passive_forces(element, kind)?;
            joint.mimic = self.mimic(element)?;
        }
        self.read(
            element,
            format!("{} joint from {:?} to {:?}", kind.name(), excerpt(parent), excerpt(child)),
        );
        Ok(joint)
    }

    fn link_of(&mut self, joint: &Element<'a>, role: &'static str) -> Result<&'a str, UrdfError> {
        let advice = "write <parent link=\"NAME\"/> and <child link=\"NAME\"/>";
        let element = self.required_child(joint, role, advice)?;
        self.list_unread(&element, &["link"], &[], Unknown::IsPhysics)?;
        element.required_name("link", "link=\"NAME\"")
    }

    /// The axis in the joint's frame, as written; (1, 0, 0) by default.
    fn axis(&mut self, joint: &Element<'a>, name: &str) -> Result<[f64; 3], UrdfError> {
        const DEFAULT: [f64; 3] = [1.0, 0.0, 0.0];
        let Some(element) = self.child(joint, "axis")? else {
            self.defaulted(joint, "no <axis>: taken as xyz=\"1 0 0\"");
            return Ok(DEFAULT);
        };
        self.list_unread(&element, &["xyz"], &[], Unknown::IsPhysics)?;
        element.required_text("xyz", "xyz=\"0 0 1\" or another direction")?;
        let axis = element.numbers::<3>("xyz")?.unwrap_or(DEFAULT);
        if axis.iter().all(|c| c.abs() < SHORTEST_AXIS) {
            return Err(UrdfError::ZeroAxis { line: element.line, joint: excerpt(name) });
        }
        self.read(&element, "direction");
        Ok(axis)
    }

    /// Lists an element that says nothing about a joint of this kind.
    fn without_motion(
        &mut self,
        joint: &Element<'a>,
        kind: JointKind,
        name: &'static str,
    ) -> Result<(), UrdfError> {
        if let Some(element) = self.child(joint, name)? {
            self.ignored(element.line, element.place, format!("a {} joint has no <{name}>", kind.name()));
        }
        Ok(())
    }
}
