//! `<dynamics>`: the forces of the joint itself.

use multibody::{JointKind, PassiveForces};

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// Damping and friction; and, beyond the standard, the armature (rotor inertia through the gear) and a
    /// spring: `armature`, `stiffness` or `spring_stiffness`, `rest` or `spring_reference`.
    pub(crate) fn passive_forces(&mut self, joint: &Element<'a>, kind: JointKind) -> PassiveForces {
        let Some(element) = self.child(joint, "dynamics") else {
            self.defaulted(joint, "no <dynamics>: no damping, no friction");
            return PassiveForces::default();
        };
        let known =
            ["damping", "friction", "armature", "stiffness", "spring_stiffness", "rest", "spring_reference"];
        self.list_unread(&element, &known, &[], Unknown::IsPhysics);
        for name in ["damping", "friction"] {
            if element.text(name).is_none() {
                self.defaulted(&element, format!("no {name}: taken as 0"));
            }
        }
        let [armature, damping, friction] = ["armature", "damping", "friction"].map(|name| {
            let value = self.number(&element, name).unwrap_or(0.0);
            self.expect_positive(&element, name, value, "it adds energy to the motion");
            value
        });
        let stiffness = self.either(&element, "stiffness", "spring_stiffness");
        self.expect_positive(&element, "stiffness", stiffness, "this spring pushes away from its rest");
        let rest = self.either(&element, "rest", "spring_reference");
        let passive = PassiveForces::default()
            .with_armature(armature)
            .with_damping(damping)
            .with_friction(friction)
            .with_spring(stiffness, rest);
        if matches!(kind, JointKind::Spherical | JointKind::Floating) && passive.stiffness != 0.0 {
            let message = format!("a {} joint has no spring here", kind.name());
            self.ignored_physics(element.line, element.place.clone(), message);
            return passive.with_spring(0.0, 0.0);
        }
        self.read(&element, "passive forces");
        passive
    }

    fn expect_positive(&mut self, element: &Element<'a>, name: &str, value: f64, effect: &str) {
        if value < 0.0 {
            self.as_written(
                element,
                format!("{name}={value} is negative: taken as written, {effect}; correct its sign"),
            );
        }
    }

    /// One number under either of two names.
    fn either(&mut self, element: &Element<'a>, first: &'static str, second: &'static str) -> f64 {
        match (self.number(element, first), self.number(element, second)) {
            (Some(_), Some(_)) => {
                let (line, place) = (element.line, element.place.clone());
                self.refuse(UrdfError::Both { line, place, first, second });
                f64::NAN
            }
            (one, other) => one.or(other).unwrap_or(0.0),
        }
    }
}
