//! `<limit>`: bounds on position, speed and effort.

use multibody::{JointDescription, JointKind, Limits};

use crate::UrdfError;
use crate::element::Element;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// The bounds, infinite where there are none. A `<limit>` without `lower` or `upper` means 0 there.
    pub(crate) fn limits(
        &mut self,
        element: &Element<'a>,
        joint: &JointDescription,
    ) -> Result<Limits, UrdfError> {
        let mut limits = Limits::default();
        let Some(element) = self.child(element, "limit")? else {
            self.defaulted(element, "no <limit>: position, speed and effort without bounds");
            return Ok(limits);
        };
        self.list_unread(&element, &["lower", "upper", "effort", "velocity"], &[], Unknown::IsHarmless)?;
        if matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. }) {
            (limits.lower, limits.upper) = self.range(&element, &joint.name)?;
        } else {
            for name in ["lower", "upper"] {
                if element.text(name).is_some() {
                    let message = format!("{name}: a {} joint has no position bounds", joint.kind.name());
                    self.ignored(element.line, element.place.clone(), message);
                }
            }
        }
        limits.effort = self.magnitude(&element, "effort")?;
        limits.velocity = self.magnitude(&element, "velocity")?;
        self.read(&element, "bounds");
        Ok(limits)
    }

    fn range(&mut self, element: &Element<'a>, joint: &str) -> Result<(f64, f64), UrdfError> {
        let bounds = [element.bound("lower")?, element.bound("upper")?];
        for (bound, name) in bounds.iter().zip(["lower", "upper"]) {
            if bound.is_none() {
                self.defaulted(element, format!("no {name}: taken as 0, as URDF has it"));
            }
        }
        let [lower, upper] = bounds.map(Option::unwrap_or_default);
        if lower > upper {
            let note = match bounds {
                [None, _] => " (lower is missing, and URDF takes 0 for it)",
                [_, None] => " (upper is missing, and URDF takes 0 for it)",
                _ => "",
            };
            return Err(UrdfError::LimitsReversed {
                line: element.line,
                joint: excerpt(joint),
                lower,
                upper,
                note,
            });
        }
        Ok((lower, upper))
    }

    /// A bound on an absolute value.
    fn magnitude(&mut self, element: &Element<'a>, name: &str) -> Result<f64, UrdfError> {
        let Some(value) = element.bound(name)? else {
            self.defaulted(element, format!("no {name}: without bound"));
            return Ok(f64::INFINITY);
        };
        element.not_negative(name, value, "it bounds an absolute value")
    }
}
