//! Reads values that are the text of child elements, and poses.

use robot_dynamics_description::Pose;
use robot_dynamics_xml::excerpt;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// A pose with the name of the frame that it is relative to.
pub(super) struct RelativePose<'a> {
    pub(super) relative_to: Option<&'a str>,
    pub(super) pose: Pose,
}

impl<'a> Reader<'a> {
    /// The text of a child element without white space around it; `None` if it is missing.
    pub(super) fn child_text(&mut self, parent: &Element<'a>, name: &str) -> Option<(Element<'a>, &'a str)> {
        let element = self.child(parent, name)?;
        let text = element.node.text().unwrap_or_default().trim();
        Some((element, text))
    }

    /// The text of a required child element.
    pub(super) fn required_child_text(
        &mut self,
        parent: &Element<'a>,
        name: &'static str,
        advice: &'static str,
    ) -> &'a str {
        let Some(element) = self.required_child(parent, name, advice) else { return "" };
        let text = element.node.text().unwrap_or_default().trim();
        if text.is_empty() {
            let (line, place) = (element.line, element.place);
            self.refuse(UrdfError::MissingElement { line, place, element: name, advice });
        }
        text
    }

    /// The number in a child element.
    pub(super) fn child_number(&mut self, parent: &Element<'a>, name: &str) -> Option<f64> {
        let (element, text) = self.child_text(parent, name)?;
        Some(self.parsed(element.parse_finite(name, text, text)))
    }

    /// A bound: numbers from 1e16 on, and infinities, are no bound.
    pub(super) fn child_bound(&mut self, parent: &Element<'a>, name: &str) -> Option<f64> {
        let (element, text) = self.child_text(parent, name)?;
        let bound = self.parsed(element.parse_real(name, text, text));
        Some(if bound.abs() >= 1e16 { f64::INFINITY.copysign(bound) } else { bound })
    }

    /// Numbers in a child element.
    pub(super) fn child_numbers<const N: usize>(
        &mut self,
        parent: &Element<'a>,
        name: &str,
    ) -> Option<[f64; N]> {
        let (element, text) = self.child_text(parent, name)?;
        Some(self.text_numbers(&element, name, text))
    }

    /// `N` numbers in a text; NaN after an error.
    pub(super) fn text_numbers<const N: usize>(
        &mut self,
        element: &Element<'a>,
        name: &str,
        text: &str,
    ) -> [f64; N] {
        let Some(list) = self.list(element, name, text) else { return [f64::NAN; N] };
        let found = list.len();
        list.try_into().unwrap_or_else(|_| {
            let (line, place, attribute) = (element.line, element.place.clone(), name.to_owned());
            let text = excerpt(text);
            self.refuse(UrdfError::WrongCount { line, place, attribute, text, expected: N, found });
            [f64::NAN; N]
        })
    }

    /// A truth value: 1, true, 0 or false.
    pub(super) fn child_flag(&mut self, parent: &Element<'a>, name: &str) -> Option<bool> {
        let (element, text) = self.child_text(parent, name)?;
        self.flag(&element, text)
    }

    pub(super) fn flag(&mut self, element: &Element<'a>, text: &str) -> Option<bool> {
        match text.to_ascii_lowercase().as_str() {
            "1" | "true" => Some(true),
            "0" | "false" => Some(false),
            _ => {
                let reason = format!("{:?} is not a truth value; write true or false", excerpt(text));
                self.refuse_sdf(element, reason);
                None
            }
        }
    }

    /// Lists an error.
    pub(super) fn refuse_sdf(&mut self, element: &Element<'a>, reason: impl Into<String>) {
        let (line, place, reason) = (element.line, element.place.clone(), reason.into());
        self.refuse(UrdfError::BadSemantics { line, place, reason });
    }

    fn parsed(&mut self, number: Result<f64, UrdfError>) -> f64 {
        number.unwrap_or_else(|error| {
            self.refuse(error);
            f64::NAN
        })
    }

    /// The name of an element, which may not be one of those that SDF reserves.
    pub(super) fn own_name(&mut self, element: &Element<'a>) -> &'a str {
        let name = self.required_name(element, "name", "name=\"NAME\"");
        let is_reserved = name == "world" || (name.starts_with("__") && name.ends_with("__"));
        if is_reserved || name.contains("::") {
            let reason = format!("the name {:?} is reserved or contains `::`; rename it", excerpt(name));
            self.refuse_sdf(element, reason);
            return "";
        }
        name
    }

    /// The `<pose>` of an element: x y z, then roll, pitch and yaw or a quaternion.
    pub(super) fn pose(&mut self, parent: &Element<'a>) -> RelativePose<'a> {
        let Some(element) = self.child(parent, "pose") else {
            return RelativePose { relative_to: None, pose: Pose::IDENTITY };
        };
        let known = ["relative_to", "frame", "degrees", "rotation_format"];
        self.list_unread_attributes(&element, &known, UnknownPart::Physics);
        let named = element.text("relative_to").or(element.text("frame"));
        let relative_to = named.map(str::trim).filter(|name| !name.is_empty());
        let text = element.node.text().unwrap_or_default().trim();
        let degrees = element.text("degrees").and_then(|text| self.flag(&element, text)) == Some(true);
        let pose = match element.text("rotation_format").unwrap_or("euler_rpy") {
            "euler_rpy" | "quat_xyzw" if text.is_empty() => Pose::IDENTITY,
            "euler_rpy" => {
                let [x, y, z, angles @ ..] = self.text_numbers::<6>(&element, "pose", text);
                Pose::from_xyz_rpy([x, y, z], if degrees { angles.map(f64::to_radians) } else { angles })
            }
            "quat_xyzw" => {
                let [x, y, z, quaternion @ ..] = self.text_numbers::<7>(&element, "pose", text);
                // The squares of smaller numbers underflow. After another error the number is NaN.
                if quaternion.iter().all(|c| c.abs() < 1e-100) {
                    self.refuse_sdf(&element, "the quaternion is zero; write 0 0 0 1 for no rotation");
                }
                let is_valid =
                    quaternion.iter().all(|c| c.is_finite()) && quaternion.iter().any(|c| c.abs() >= 1e-100);
                if is_valid {
                    Pose::from_translation_quaternion_xyzw([x, y, z], quaternion)
                } else {
                    Pose::IDENTITY
                }
            }
            other => {
                let reason = format!(
                    "the rotation format {:?} is unknown; use euler_rpy or quat_xyzw",
                    excerpt(other)
                );
                self.refuse_sdf(&element, reason);
                Pose::IDENTITY
            }
        };
        RelativePose { relative_to, pose }
    }
}
