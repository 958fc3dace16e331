//! Extensions of the robot simulator Drake: elements with the prefix `drake`.
//!
//! - `<drake:joint>` of the types `ball`, `universal`, `screw` and `planar`. The axes of a universal joint
//!   are x and y of its frame; the normal of a planar joint is z, and its damping has three numbers. A screw
//!   has `<drake:screw_thread_pitch value="…"/>` in m per turn.
//! - `<drake:rotor_inertia value="…"/>` and `<drake:gear_ratio value="…"/>` in the actuator of a
//!   `<transmission>`: the reflected inertia ratio²·rotor of its joint.

use core::f64::consts::TAU;

use robot_dynamics_description::{JointKind, RobotDescription};
use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;

/// Whether an element has Drake's prefix, declared or not, and this name.
pub(crate) fn is_drake(node: Node<'_, '_>, name: &str) -> bool {
    let tag = node.tag_name();
    node.is_element() && tag.name() == name && tag.namespace().is_some_and(|name| name.contains("drake"))
}

/// The reflected inertia of a motor.
pub(crate) struct ReflectedInertia<'a> {
    element: Element<'a>,
    joint: String,
    /// \[kg m²\], or \[kg\] of a prismatic joint.
    value: f64,
}

impl<'a> Reader<'a> {
    /// The kind of a `<drake:joint>` of this type; `None` if Drake has no such type.
    pub(crate) fn drake_joint(&mut self, joint: &Element<'a>, name: &str, kind: &str) -> Option<JointKind> {
        Some(match kind {
            "ball" => JointKind::Spherical,
            "universal" => JointKind::Universal { first: [1.0, 0.0, 0.0], second: [0.0, 1.0, 0.0] },
            "planar" => JointKind::Planar { normal: [0.0, 0.0, 1.0] },
            "screw" => {
                let axis = self.axis(joint, name);
                let pitch = self.drake_value(joint, "screw_thread_pitch");
                if pitch.is_none() {
                    let (line, place) = (joint.line, joint.place.clone());
                    let advice = "write <drake:screw_thread_pitch value=\"METRES PER TURN\"/>";
                    let element = "drake:screw_thread_pitch";
                    self.refuse(UrdfError::MissingElement { line, place, element, advice });
                }
                JointKind::Helical { axis, pitch: pitch.unwrap_or(0.0) / TAU }
            }
            _ => return None,
        })
    }

    /// The number of a child `<drake:NAME value="…"/>`.
    fn drake_value(&mut self, parent: &Element<'a>, name: &str) -> Option<f64> {
        let node = parent.node.children().find(|&node| is_drake(node, name))?;
        self.understood.insert(node.id());
        let element =
            Element { node, line: self.line(node), place: format!("{}/drake:{name}", parent.place) };
        let value = self.number(&element, "value");
        if value.is_none() {
            self.required_text(&element, "value", "value=\"NUMBER\"");
        }
        value
    }

    /// The damping of a planar joint. Drake writes three numbers, for x, y and the rotation. One number
    /// counts for all.
    pub(crate) fn planar_damping(&mut self, dynamics: &Element<'a>) -> Option<f64> {
        let text = dynamics.text("damping")?;
        if text.split_ascii_whitespace().count() < 2 {
            return self.number(dynamics, "damping");
        }
        let [x, y, rotation] = self.numbers::<3>(dynamics, "damping")?;
        if x == y && y == rotation {
            return Some(x);
        }
        let message = format!(
            "damping={:?} is not in the model: a planar joint has one damping for its three directions",
            excerpt(text)
        );
        self.report_ignored_physics(dynamics.line, dynamics.place.clone(), message);
        None
    }

    /// Reads the reflected inertias of `<transmission>`s with one joint and one actuator.
    pub(crate) fn reflected_inertias(&mut self, robot: &Element<'a>) -> Vec<ReflectedInertia<'a>> {
        let transmissions: Vec<_> =
            robot.node.children().filter(|&node| self.is(node, "transmission")).collect();
        transmissions.into_iter().filter_map(|node| self.reflected_inertia(node)).collect()
    }

    fn reflected_inertia(&mut self, node: Node<'a, 'a>) -> Option<ReflectedInertia<'a>> {
        let only = |name| {
            let mut found = node.children().filter(|&child| self.is(child, name));
            found.next().filter(|_| found.next().is_none())
        };
        let (joint, actuator) = (only("joint")?, only("actuator")?);
        actuator.children().find(|&child| is_drake(child, "rotor_inertia"))?;
        let joint = joint.attribute("name")?.to_owned();
        let transmission = self.named_element(node, "transmission");
        let place = format!("{}/actuator", transmission.place);
        let element = Element { node: actuator, line: self.line(actuator), place };
        let rotor = self.drake_value(&element, "rotor_inertia")?;
        let ratio = self.drake_value(&element, "gear_ratio").unwrap_or(1.0);
        Some(ReflectedInertia { element, joint, value: ratio * ratio * rotor })
    }

    /// Adds the reflected inertias to the armatures of their joints.
    pub(crate) fn add_reflected_inertias(
        &mut self,
        robot: &mut RobotDescription,
        reflected: &[ReflectedInertia<'a>],
    ) {
        for ReflectedInertia { element, joint: name, value } in reflected {
            let moves = |kind| !matches!(kind, JointKind::Fixed);
            let own = robot.joints.iter_mut().find(|joint| joint.name == *name && moves(joint.kind));
            let name = excerpt(name);
            if let Some(joint) = own {
                joint.passive.armature += value;
                let message = format!(
                    "the reflected inertia gear_ratio²·rotor_inertia = {value} is added to the armature of joint {name:?}"
                );
                self.report_default(element, message);
            } else {
                let message = format!(
                    "the reflected inertia {value} is not in the model: there is no moving joint {name:?}"
                );
                self.report_ignored_physics(element.line, element.place.clone(), message);
            }
        }
    }
}
