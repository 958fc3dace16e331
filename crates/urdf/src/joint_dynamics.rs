//! `<dynamics>`: the forces of the joint itself.

use multibody::{JointKind, PassiveForces};

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// Damping and friction; and, beyond the standard, the armature (rotor inertia through the gear) and a
    /// spring: `armature`, `stiffness` or `spring_stiffness`, `rest` or `spring_reference`.
    pub(crate) fn passive_forces(
        &mut self,
        joint: &Element<'a>,
        kind: JointKind,
    ) -> Result<PassiveForces, UrdfError> {
        let Some(element) = self.child(joint, "dynamics")? else {
            self.defaulted(joint, "no <dynamics>: no damping, no friction");
            return Ok(PassiveForces::default());
        };
        let known =
            ["damping", "friction", "armature", "stiffness", "spring_stiffness", "rest", "spring_reference"];
        self.list_unread(&element, &known, &[], Unknown::IsPhysics)?;
        let advice = "a negative one would add energy";
        for name in ["damping", "friction"] {
            if element.text(name).is_none() {
                self.defaulted(&element, format!("no {name}: taken as 0"));
            }
        }
        let at_least_zero = |name: &str| -> Result<f64, UrdfError> {
            element.not_negative(name, element.number(name)?.unwrap_or(0.0), advice)
        };
        let stiffness = either(&element, "stiffness", "spring_stiffness")?;
        let passive = PassiveForces {
            armature: at_least_zero("armature")?,
            damping: at_least_zero("damping")?,
            friction: at_least_zero("friction")?,
            stiffness: element.not_negative("stiffness", stiffness, "a spring pulls towards its rest")?,
            rest: either(&element, "rest", "spring_reference")?,
        };
        if matches!(kind, JointKind::Spherical | JointKind::Floating) && passive.stiffness != 0.0 {
            let message = format!("a {} joint has no spring here", kind.name());
            self.ignored_physics(element.line, element.place.clone(), message)?;
            return Ok(PassiveForces { stiffness: 0.0, rest: 0.0, ..passive });
        }
        self.read(&element, "passive forces");
        Ok(passive)
    }
}

/// One number under either of two names.
fn either(element: &Element<'_>, first: &'static str, second: &'static str) -> Result<f64, UrdfError> {
    match (element.number(first)?, element.number(second)?) {
        (Some(_), Some(_)) => {
            Err(UrdfError::Both { line: element.line, place: element.place.clone(), first, second })
        }
        (one, other) => Ok(one.or(other).unwrap_or(0.0)),
    }
}
