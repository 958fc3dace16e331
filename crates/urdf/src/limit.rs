//! `<limit>`: bounds on position, speed and effort.

use multibody::{JointKind, Limits};

use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// The bounds, infinite where there are none. A `<limit>` without `lower` or `upper` means 0 there.
    pub(crate) fn limits(&mut self, joint: &Element<'a>, kind: JointKind) -> Limits {
        let mut limits = Limits::default();
        let Some(element) = self.child(joint, "limit") else {
            self.defaulted(joint, "no <limit>: position, speed and effort without bounds");
            return limits;
        };
        self.list_unread(&element, &["lower", "upper", "effort", "velocity"], &[], Unknown::IsHarmless);
        if matches!(kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. }) {
            (limits.lower, limits.upper) = self.range(&element);
        } else {
            for name in ["lower", "upper"] {
                if element.text(name).is_some() {
                    let message = format!("{name}: a {} joint has no position bounds", kind.name());
                    self.ignored(element.line, element.place.clone(), message);
                }
            }
        }
        limits.effort = self.magnitude(&element, "effort", "the motor can give no force");
        limits.velocity = self.magnitude(&element, "velocity", "the joint may not move");
        self.read(&element, "bounds");
        limits
    }

    fn range(&mut self, element: &Element<'a>) -> (f64, f64) {
        let bounds = ["lower", "upper"].map(|name| {
            let bound = self.bound(element, name);
            if bound.is_none() {
                self.defaulted(element, format!("no {name}: taken as 0, as URDF has it"));
            }
            bound
        });
        let [lower, upper] = bounds.map(Option::unwrap_or_default);
        if lower > upper {
            let note = match bounds {
                [None, _] => " (lower is missing, and URDF takes 0 for it)",
                [_, None] => " (upper is missing, and URDF takes 0 for it)",
                _ => "",
            };
            self.as_written(
                element,
                format!(
                    "the lower limit {lower} is above the upper limit {upper}{note}: taken as written, no position \
                     is within them; exchange or correct them"
                ),
            );
        }
        (lower, upper)
    }

    /// A bound on an absolute value.
    fn magnitude(&mut self, element: &Element<'a>, name: &str, zero_means: &str) -> f64 {
        let Some(value) = self.bound(element, name) else {
            self.defaulted(element, format!("no {name}: without bound"));
            return f64::INFINITY;
        };
        if value == 0.0 {
            self.as_written(
                element,
                format!("{name}=\"0\": taken as written, {zero_means}; leave it out if there is no bound"),
            );
        }
        if value < 0.0 {
            let magnitude = -value;
            self.as_written(
                element,
                format!("{name}={value} is negative, but bounds an absolute value: taken as {magnitude}; correct it"),
            );
        }
        value.abs()
    }
}
