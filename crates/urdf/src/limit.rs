//! Reads `<limit>`: bounds on position, speed and effort.

use robot_dynamics_description::{JointKind, Limits};

use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

impl<'a> Reader<'a> {
    /// Reads the bounds; missing ones are infinite, but `lower` and `upper` of a `<limit>` default to 0.
    pub(crate) fn limits(&mut self, joint: &Element<'a>, kind: JointKind) -> Limits {
        let mut limits = Limits::default();
        let Some(element) = self.child(joint, "limit") else {
            self.report_default(joint, "no <limit>: no bounds on position, speed and effort");
            return limits;
        };
        self.list_unread(&element, &["lower", "upper", "effort", "velocity"], &[], UnknownPart::Harmless);
        if matches!(kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. }) {
            (limits.lower, limits.upper) = self.range(&element);
        } else {
            for name in ["lower", "upper"] {
                if element.text(name).is_some() {
                    let message = format!("{name}: a {} joint has no position bounds", kind.name());
                    self.report_ignored(element.line, element.place.clone(), message);
                }
            }
        }
        limits.effort = self.magnitude(&element, "effort", "so that the motor has no force");
        limits.velocity = self.magnitude(&element, "velocity", "so that the joint cannot move");
        self.report_read(&element, "bounds");
        limits
    }

    fn range(&mut self, element: &Element<'a>) -> (f64, f64) {
        let bounds = ["lower", "upper"].map(|name| {
            let bound = self.bound(element, name);
            if bound.is_none() {
                self.report_default(element, format!("no {name}: taken as 0, the default of URDF"));
            }
            bound
        });
        let [lower, upper] = bounds.map(Option::unwrap_or_default);
        if lower > upper {
            let note = match bounds {
                [None, _] => " (lower is missing, and its default is 0)",
                [_, None] => " (upper is missing, and its default is 0)",
                _ => "",
            };
            self.warn(
                element,
                format!(
                    "the lower limit {lower} is above the upper limit {upper}{note}: taken as written, so that no \
                     position satisfies them; exchange or correct them"
                ),
            );
        }
        (lower, upper)
    }

    /// A bound on a magnitude.
    fn magnitude(&mut self, element: &Element<'a>, name: &str, zero_means: &str) -> f64 {
        let Some(value) = self.bound(element, name) else {
            self.report_default(element, format!("no {name}: no bound"));
            return f64::INFINITY;
        };
        if value == 0.0 {
            self.warn(element, format!("{name}=\"0\": taken as written, {zero_means}; omit it for no bound"));
        }
        if value < 0.0 {
            let magnitude = -value;
            self.warn(
                element,
                format!(
                    "{name}={value} is negative, but bounds a magnitude: taken as {magnitude}; correct it"
                ),
            );
        }
        value.abs()
    }
}
