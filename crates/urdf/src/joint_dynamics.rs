//! Reads `<dynamics>`: the passive forces of a joint.

use robot_dynamics_description::{JointKind, PassiveForces};

use crate::UrdfError;
use crate::drake::is_drake;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

impl<'a> Reader<'a> {
    /// Reads damping and friction. Beyond the standard it reads the armature (rotor inertia through the gear)
    /// and a spring: `armature`, `stiffness` or `spring_stiffness`, `rest` or `spring_reference`. `name` is
    /// that of [`passive_forces_element`](Self::passive_forces_element).
    pub(crate) fn passive_forces(
        &mut self,
        joint: &Element<'a>,
        name: &str,
        kind: JointKind,
    ) -> PassiveForces {
        let Some(element) = self.child(joint, name) else {
            self.report_default(joint, "no <dynamics>: no damping, no friction");
            return PassiveForces::default();
        };
        let known =
            ["damping", "friction", "armature", "stiffness", "spring_stiffness", "rest", "spring_reference"];
        self.list_unread(&element, &known, &[], UnknownPart::Physics);
        for name in ["damping", "friction"] {
            if element.text(name).is_none() {
                self.report_default(&element, format!("no {name}: taken as 0"));
            }
        }
        let planar_of_drake = matches!(kind, JointKind::Planar { .. }) && is_drake(joint.node, "joint");
        let [armature, damping, friction] = ["armature", "damping", "friction"].map(|name| {
            let value = match name {
                "damping" if planar_of_drake => self.planar_damping(&element),
                _ => self.number(&element, name),
            };
            let value = value.unwrap_or(0.0);
            self.warn_if_negative(&element, name, value, "which adds energy to the motion");
            value
        });
        let stiffness = self.number_of(&element, "stiffness", "spring_stiffness");
        self.warn_if_negative(
            &element,
            "stiffness",
            stiffness,
            "so that the spring pushes away from its rest position",
        );
        let rest = self.number_of(&element, "rest", "spring_reference");
        let passive = PassiveForces::default()
            .with_armature(armature)
            .with_damping(damping)
            .with_friction(friction)
            .with_spring(stiffness, rest);
        if matches!(kind, JointKind::Spherical | JointKind::Floating) && passive.stiffness != 0.0 {
            let message = format!("springs of {} joints are not supported", kind.name());
            self.report_ignored_physics(element.line, element.place.clone(), message);
            return passive.with_spring(0.0, 0.0);
        }
        self.report_read(&element, "passive forces");
        passive
    }

    /// The name of the element with the passive forces: `joint_properties` in files before 2010.
    pub(crate) fn passive_forces_element(&self, joint: &Element<'a>) -> &'static str {
        let has = |name| joint.node.children().any(|child| self.is(child, name));
        if has("joint_properties") && !has("dynamics") { "joint_properties" } else { "dynamics" }
    }

    pub(crate) fn warn_if_negative(&mut self, element: &Element<'a>, name: &str, value: f64, effect: &str) {
        if value < 0.0 {
            self.warn(
                element,
                format!("{name}={value} is negative: taken as written, {effect}; correct its sign"),
            );
        }
    }

    /// A number that has two attribute names.
    fn number_of(&mut self, element: &Element<'a>, first: &'static str, second: &'static str) -> f64 {
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
