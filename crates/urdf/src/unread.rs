//! What a file holds beyond the elements that are read: listed, and judged whether it is physics.

use robot_xml::roxmltree::Node;

use crate::element::Element;
use crate::reader::Reader;
use crate::xacro::is_instruction;
use robot_xml::excerpt;

/// Elements that say how the robot looks.
const SHAPE: [&str; 3] = ["visual", "collision", "material"];

/// Elements that are known not to change how the robot moves, with what they are.
const HARMLESS: [(&str, &str); 13] = [
    ("transmission", "a transmission couples motors to joints"),
    ("gazebo", "an extension for the Gazebo simulator"),
    ("ros2_control", "an extension for controllers"),
    ("safety_controller", "soft limits for a controller"),
    ("calibration", "reference positions for a calibration"),
    ("sensor", "a sensor"),
    ("plugin", "a program for a simulator"),
    ("contact", "surface properties for contacts"),
    ("group", "a semantic group of links"),
    ("mujoco", "an extension for the MuJoCo simulator"),
    ("self_collision_checking", "shapes for a planner"),
    ("verbose", "a display setting"),
    ("hardwareInterface", "a driver setting"),
];

/// Names, in lower case and without separators, that carry physics, with the value that does nothing.
const PHYSICS: [(&str, f64); 24] = [
    ("mechanicalreduction", 1.0),
    ("gearratio", 1.0),
    ("rotorinertia", 0.0),
    ("motorinertia", 0.0),
    ("armature", 0.0),
    ("damping", 0.0),
    ("dampingfactor", 0.0),
    ("friction", 0.0),
    ("frictionloss", 0.0),
    ("stiffness", 0.0),
    ("springstiffness", 0.0),
    ("springreference", 0.0),
    ("implicitspringdamper", 0.0),
    ("springref", 0.0),
    ("gravity", 1.0),
    ("turngravityoff", 0.0),
    ("gravcomp", 0.0),
    ("mass", 0.0),
    ("inertia", f64::NAN),
    ("inertial", f64::NAN),
    ("loopjoint", f64::NAN),
    ("ballconstraint", f64::NAN),
    ("linearspringdamper", f64::NAN),
    ("linearbushingrpy", f64::NAN),
];

/// Whether an unknown part of an element is to be taken for physics.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unknown {
    /// Inside inertias and joints, where a number that is not understood may change the motion.
    IsPhysics,
    /// Elsewhere, unless its name says otherwise.
    IsHarmless,
}

impl<'a> Reader<'a> {
    /// Lists everything in `element` but the given attributes and child elements.
    pub(crate) fn list_unread(
        &mut self,
        element: &Element<'a>,
        attributes: &[&str],
        children: &[&str],
        unknown: Unknown,
    ) {
        for attribute in element.node.attributes() {
            let name = attribute.name();
            if attribute.namespace().is_some() {
                self.ignored(element.line, element.place.clone(), format!("foreign attribute `{name}`"));
            } else if name == "dont_collapse" {
                // For converters: keep this fixed joint's link.
                self.ignored(element.line, element.place.clone(), format!("setting `{name}`"));
            } else if !attributes.contains(&name) {
                let message = format!("unknown attribute {}={:?}", excerpt(name), excerpt(attribute.value()));
                if unknown == Unknown::IsPhysics || carries_physics(name, attribute.value()) {
                    self.ignored_physics(element.line, element.place.clone(), message);
                } else {
                    self.ignored(element.line, element.place.clone(), message);
                }
            }
        }
        for node in element.node.children() {
            let name = node.tag_name().name();
            let text = node.text().filter(|_| node.is_text()).unwrap_or_default();
            if !text.trim().is_empty() {
                let leading = text.len() - text.trim_start().len();
                let line = self.line_of_byte(node.range().start + leading);
                self.ignored(line, element.place.clone(), format!("loose text {:?}", excerpt(text.trim())));
            } else if !node.is_element() || (self.is_own(node) && children.contains(&name)) {
                // Read elsewhere, or a comment.
            } else if self.is_own(node) && SHAPE.contains(&name) {
                self.report.counts.not_dynamics += 1;
            } else {
                self.list_subtree(element, node, unknown);
            }
        }
    }

    /// One entry for an element that is not read, one more for each piece of physics inside it.
    fn list_subtree(&mut self, parent: &Element<'a>, node: Node<'a, 'a>, unknown: Unknown) {
        let name = node.tag_name().name();
        let line = self.line(node);
        let place = format!("{}/{}", parent.place, excerpt(name));
        if is_instruction(node) {
            let message = "an unprocessed xacro instruction: what it would add is missing; run `xacro FILE > robot.urdf` \
                           and load that";
            self.ignored_physics(line, place, message);
            return;
        }
        if let Some((_, what)) = HARMLESS.iter().find(|(harmless, _)| *harmless == name) {
            let named = node.attribute("reference").or(node.attribute("name"));
            let of = named.map(|name| format!(" ({:?})", excerpt(name))).unwrap_or_default();
            self.ignored(line, place.clone(), format!("{what}{of}"));
        } else if unknown == Unknown::IsPhysics && !is_physics(node) {
            self.ignored_physics(line, place.clone(), "unknown element, perhaps physics");
        } else if !is_physics(node) {
            self.ignored(line, place.clone(), "unknown element");
        }
        for inner in node.descendants().filter(Node::is_element) {
            let line = self.line(inner);
            let name = inner.tag_name().name();
            if is_physics(inner) {
                let value = value_of(inner).trim();
                let value = if value.is_empty() { String::new() } else { format!(" = {}", excerpt(value)) };
                let message = format!("{}{value} is not in the model", excerpt(name));
                self.ignored_physics(line, place.clone(), message);
            }
            for attribute in inner.attributes() {
                if carries_physics(attribute.name(), attribute.value()) {
                    let value = excerpt(attribute.value());
                    let message =
                        format!("{}/{} = {value} is not in the model", excerpt(name), attribute.name());
                    self.ignored_physics(line, place.clone(), message);
                }
            }
        }
    }
}

/// Whether an element that is not read changes how the robot moves.
fn is_physics(node: Node<'_, '_>) -> bool {
    let name = node.tag_name().name();
    // A joint with a type is a joint of the mechanism; one without is a reference to it. A <friction> with
    // elements in it describes a surface.
    let makes_joint = name == "joint" && node.attribute("type").is_some();
    let describes_surface = name == "friction" && node.children().any(|child| child.is_element());
    makes_joint || (!describes_surface && carries_physics(name, value_of(node)))
}

/// The number that an element holds, by attribute or as text.
fn value_of<'a>(node: Node<'a, 'a>) -> &'a str {
    node.attribute("value").or_else(|| node.text()).unwrap_or_default()
}

/// Whether a thing of this name and value changes how a robot moves.
fn carries_physics(name: &str, value: &str) -> bool {
    let plain: String = name
        .chars()
        .take(40)
        .filter(|letter| letter.is_alphanumeric())
        .map(|letter| letter.to_ascii_lowercase())
        .collect();
    let Some(&(_, neutral)) = PHYSICS.iter().find(|(word, _)| *word == plain) else { return false };
    let value = match value.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        text => text.parse::<f64>().ok(),
    };
    value != Some(neutral)
}
