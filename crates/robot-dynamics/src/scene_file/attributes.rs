//! Reads the attributes of an element. Attributes that nothing reads are errors.

use robot_dynamics_description::similar;
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Lines, excerpt};

use super::fault::SceneFault;
use crate::description::{JointKind, Mount, Pose, Surface};

/// The attributes of one element, with the errors of reading them.
pub(super) struct Attributes<'a> {
    node: Node<'a, 'a>,
    pub(super) line: usize,
    /// As in `box "cube"`.
    pub(super) place: String,
    known: Vec<&'static str>,
    faults: Vec<SceneFault>,
}

impl<'a> Attributes<'a> {
    pub(super) fn of(node: Node<'a, '_>, lines: &Lines) -> Attributes<'a> {
        let kind = node.tag_name().name();
        let named = node.attribute("name").or_else(|| node.attribute("file"));
        let place =
            named.map_or_else(|| excerpt(kind), |name| format!("{} {:?}", excerpt(kind), excerpt(name)));
        let line = lines.line(node.range().start);
        Attributes { node, line, place, known: Vec::new(), faults: Vec::new() }
    }

    pub(super) fn refuse(&mut self, message: impl Into<String>) {
        self.faults.push(SceneFault::new(self.line, &self.place, message));
    }

    pub(super) fn text(&mut self, attribute: &'static str) -> Option<&'a str> {
        self.known.push(attribute);
        self.node.attribute(attribute)
    }

    pub(super) fn required(&mut self, attribute: &'static str, example: &str) -> Option<&'a str> {
        let text = self.text(attribute);
        if text.is_none_or(|text| text.trim().is_empty()) {
            self.refuse(format!("the attribute `{attribute}` is missing; write {attribute}=\"{example}\""));
            return None;
        }
        text
    }

    /// `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&mut self, attribute: &'static str) -> Option<[f64; N]> {
        let text = self.text(attribute)?;
        let words: Vec<&str> = text.split_ascii_whitespace().take(N + 1).collect();
        let numbers: Option<Vec<f64>> =
            words.iter().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let numbers = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        if numbers.is_none() {
            let count = if N == 1 { "a finite number".to_owned() } else { format!("{N} finite numbers") };
            self.refuse(format!("{attribute}={:?} must be {count}", excerpt(text)));
        }
        numbers
    }

    pub(super) fn number(&mut self, attribute: &'static str) -> Option<f64> {
        self.numbers(attribute).map(|[number]| number)
    }

    /// Required numbers; NaN after an error.
    pub(super) fn required_numbers<const N: usize>(
        &mut self,
        attribute: &'static str,
        example: &str,
    ) -> [f64; N] {
        match self.required(attribute, example) {
            Some(_) => self.numbers(attribute).unwrap_or([f64::NAN; N]),
            None => [f64::NAN; N],
        }
    }

    /// `true` or `false`.
    pub(super) fn flag(&mut self, attribute: &'static str) -> bool {
        match self.text(attribute) {
            None | Some("false") => false,
            Some("true") => true,
            Some(other) => {
                self.refuse(format!("{attribute}={:?} must be true or false", excerpt(other)));
                false
            }
        }
    }

    /// `xyz` and `rpy`.
    fn pose(&mut self) -> Pose {
        let xyz = self.numbers("xyz").unwrap_or_default();
        Pose::from_xyz_rpy(xyz, self.numbers("rpy").unwrap_or_default())
    }

    /// The place of a part: its parent, pose and joint.
    pub(super) fn mount(&mut self) -> Mount {
        let parent = self.text("on").unwrap_or("world");
        let mut mount = Mount::on(parent).with_pose(self.pose());
        let axis = self.numbers("axis").unwrap_or([0.0, 0.0, 1.0]);
        let second = self.numbers("second_axis").unwrap_or([0.0, 1.0, 0.0]);
        let pitch = self.number("pitch").unwrap_or_default();
        if let Some(name) = self.text("joint") {
            match JointKind::named(name, axis, second, pitch) {
                Some(kind) => mount = mount.with_joint(kind),
                None => self.refuse(format!(
                    "joint={:?} must be fixed, revolute, continuous, prismatic, helical, universal, planar, \
                     spherical or floating",
                    excerpt(name)
                )),
            }
        }
        mount
    }

    /// Friction of an object.
    pub(super) fn surface(&mut self) -> Surface {
        let mut surface = Surface::default();
        if let Some(friction) = self.number("friction") {
            surface.friction[0] = friction;
            if friction < 0.0 {
                self.refuse(format!("friction={friction} must not be negative"));
            }
        }
        surface
    }

    /// The errors. Without other errors, attributes that were not read are errors.
    pub(super) fn finish(mut self) -> Vec<SceneFault> {
        if !self.faults.is_empty() {
            return self.faults;
        }
        for attribute in self.node.attributes() {
            let name = attribute.name();
            if !self.known.contains(&name) {
                let near = similar(name, self.known.iter().copied());
                let advice = near.map_or_else(
                    || format!("it has {}", self.known.join(", ")),
                    |near| format!("did you mean `{near}`?"),
                );
                self.refuse(format!("the attribute `{}` is unknown; {advice}", excerpt(name)));
            }
        }
        self.faults
    }
}
