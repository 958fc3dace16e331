//! Reports the elements and attributes that are not read, and whether they affect the motion.

use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::element::Element;
use crate::reader::Reader;
use crate::xacro::is_instruction;

/// Elements that describe appearance.
const APPEARANCE_ELEMENTS: [&str; 3] = ["visual", "collision", "material"];

/// Elements that do not affect the motion, with a description.
const HARMLESS_ELEMENTS: [(&str, &str); 13] = [
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

/// Names of physical quantities, in lower case and without separators, with the value that has no effect.
const PHYSICAL_QUANTITIES: [(&str, f64); 23] = [
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

/// Whether unknown parts of an element are reported as physics.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum UnknownPart {
    /// Inside inertias and joints, where an unknown number may affect the motion.
    Physics,
    /// Elsewhere, unless the name is that of a physical quantity.
    Harmless,
}

impl<'a> Reader<'a> {
    /// Reports everything in `element` except the given attributes and child elements.
    pub(crate) fn list_unread(
        &mut self,
        element: &Element<'a>,
        attributes: &[&str],
        children: &[&str],
        unknown: UnknownPart,
    ) {
        self.list_unread_attributes(element, attributes, unknown);
        for node in element.node.children() {
            let name = node.tag_name().name();
            let text = node.text().filter(|_| node.is_text()).unwrap_or_default();
            if !text.trim().is_empty() {
                let leading = text.len() - text.trim_start().len();
                let line = self.line_of_byte(node.range().start + leading);
                self.report_ignored(
                    line,
                    element.place.clone(),
                    format!("stray text {:?}", excerpt(text.trim())),
                );
            } else if !node.is_element()
                || (self.is_own(node) && children.contains(&name))
                || self.understood.contains(&node.id())
            {
                // Read elsewhere, or a comment.
            } else if self.is_own(node) && APPEARANCE_ELEMENTS.contains(&name) {
                self.report.counts.not_dynamics += 1;
            } else {
                self.list_subtree(element, node, unknown);
            }
        }
    }

    /// Reports all attributes of `element` except the given ones.
    pub(crate) fn list_unread_attributes(
        &mut self,
        element: &Element<'a>,
        attributes: &[&str],
        unknown: UnknownPart,
    ) {
        for attribute in element.node.attributes() {
            let name = attribute.name();
            if attribute.namespace().is_some() {
                self.report_ignored(
                    element.line,
                    element.place.clone(),
                    format!("foreign attribute `{name}`"),
                );
            } else if name == "dont_collapse" {
                // A setting of converters: do not merge this link into its parent.
                self.report_ignored(element.line, element.place.clone(), format!("setting `{name}`"));
            } else if !attributes.contains(&name) {
                let message = format!("unknown attribute {}={:?}", excerpt(name), excerpt(attribute.value()));
                let is_physics = unknown == UnknownPart::Physics || carries_physics(name, attribute.value());
                if is_physics && !does_nothing(element.node, name, attribute.value()) {
                    self.report_ignored_physics(element.line, element.place.clone(), message);
                } else {
                    self.report_ignored(element.line, element.place.clone(), message);
                }
            }
        }
    }

    /// Adds one entry for an element that is not read, and one for each physical quantity in it.
    fn list_subtree(&mut self, parent: &Element<'a>, node: Node<'a, 'a>, unknown: UnknownPart) {
        let name = node.tag_name().name();
        let line = self.line(node);
        let place = format!("{}/{}", parent.place, excerpt(name));
        if is_instruction(node) {
            let message = "an unexpanded xacro instruction: the elements that it would add are missing; run `xacro \
                           FILE > robot.urdf` and load robot.urdf";
            self.report_ignored_physics(line, place, message);
            return;
        }
        if let Some((_, what)) = HARMLESS_ELEMENTS.iter().find(|(harmless, _)| *harmless == name) {
            let named = node.attribute("reference").or(node.attribute("name"));
            let of = named.map(|name| format!(" ({:?})", excerpt(name))).unwrap_or_default();
            self.report_ignored(line, place.clone(), format!("{what}{of}"));
        } else if unknown == UnknownPart::Physics && !has_only_known_quantities(node) {
            self.report_ignored_physics(line, place.clone(), "unknown element, perhaps physics");
        } else if !is_physics(node) {
            self.report_ignored(line, place.clone(), "unknown element");
        }
        for inner in node.descendants().filter(Node::is_element) {
            if self.understood.contains(&inner.id()) {
                continue;
            }
            let line = self.line(inner);
            let name = inner.tag_name().name();
            if is_physics(inner) {
                let value = value_of(inner).trim();
                let value = if value.is_empty() { String::new() } else { format!(" = {}", excerpt(value)) };
                let message = format!("{}{value} is not in the model", excerpt(name));
                self.report_ignored_physics(line, place.clone(), message);
            }
            for attribute in inner.attributes() {
                if carries_physics(attribute.name(), attribute.value()) {
                    let value = excerpt(attribute.value());
                    let message =
                        format!("{}/{} = {value} is not in the model", excerpt(name), attribute.name());
                    self.report_ignored_physics(line, place.clone(), message);
                }
            }
        }
    }
}

/// Whether the numbers of an element are all known quantities, of which each is reported if it affects the
/// motion.
fn has_only_known_quantities(node: Node<'_, '_>) -> bool {
    is_physics(node)
        || node.attributes().len() > 0
            && !node
                .children()
                .any(|child| child.is_element() || !child.text().unwrap_or_default().trim().is_empty())
            && node.attributes().all(|attribute| neutral_value(attribute.name()).is_some())
}

/// Whether an element that is not read affects the motion.
fn is_physics(node: Node<'_, '_>) -> bool {
    let name = node.tag_name().name();
    // A joint with a type is a joint of the mechanism; one without a type is a reference. A <friction> with
    // child elements describes a surface.
    let makes_joint = name == "joint" && node.attribute("type").is_some();
    let describes_surface = name == "friction" && node.children().any(|child| child.is_element());
    makes_joint || (!describes_surface && carries_physics(name, value_of(node)))
}

/// The number of an element, from its attribute `value` or its text.
fn value_of<'a>(node: Node<'a, 'a>) -> &'a str {
    node.attribute("value").or_else(|| node.text()).unwrap_or_default()
}

/// Whether a quantity of this name and value affects the motion.
fn carries_physics(name: &str, value: &str) -> bool {
    let Some(neutral) = neutral_value(name) else { return false };
    let value = match value.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        text => text.parse::<f64>().ok(),
    };
    value != Some(neutral)
}

/// Whether an unknown attribute adds nothing: it repeats an entry of a symmetric inertia, or does not rotate.
fn does_nothing(node: Node<'_, '_>, name: &str, value: &str) -> bool {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let repeated = [("iyx", "ixy"), ("izx", "ixz"), ("izy", "iyz")].into_iter().find(|(own, _)| *own == name);
    match repeated {
        Some((_, entry)) => {
            let entry = node.attribute(entry).map_or(Some(0.0), number);
            entry.is_some() && entry == number(value)
        }
        None => name == "rpy" && value.split_whitespace().all(|word| number(word) == Some(0.0)),
    }
}

/// The value without effect of the physical quantity of this name; `None` for another name.
fn neutral_value(name: &str) -> Option<f64> {
    let plain: String = name
        .chars()
        .take(40)
        .filter(|letter| letter.is_alphanumeric())
        .map(|letter| letter.to_ascii_lowercase())
        .collect();
    PHYSICAL_QUANTITIES.iter().find(|(word, _)| *word == plain).map(|&(_, neutral)| neutral)
}
