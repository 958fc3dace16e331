//! Reads `scale`, `massscale` and `scaling` of a `<frame>`: the sizes, masses and forces of the elements in
//! it.

use nalgebra::Isometry3;
use robot_dynamics_description::MassProperties;

use crate::element::Element;
use crate::inertial::Inertial;
use crate::joint::{Joint, JointType};
use crate::reader::Reader;

/// The factors of the frames around an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameScale {
    /// The factor of lengths.
    pub(crate) length: f64,
    /// The factor of masses.
    mass: f64,
    /// The same factors of the frames that also scale forces: those with `scaling="similar"`.
    similar: [f64; 2],
}

impl FrameScale {
    pub(crate) const ONE: Self = Self { length: 1.0, mass: 1.0, similar: [1.0; 2] };

    /// A pose in the frame.
    pub(crate) fn place(&self, mut pose: Isometry3<f64>) -> Isometry3<f64> {
        pose.translation.vector *= self.length;
        pose
    }

    /// Mass properties about the scaled origin.
    pub(crate) fn body(&self, body: &MassProperties) -> Option<MassProperties> {
        if *self == Self::ONE {
            return Some(*body);
        }
        let Self { length, mass, .. } = *self;
        let inertia = body.inertia_about_center_of_mass() * (mass * length * length);
        MassProperties::as_written(body.mass() * mass, body.center_of_mass() * length, inertia).ok()
    }

    pub(crate) fn inertial(&self, inertial: &mut Inertial) {
        inertial.mass *= self.mass;
        inertial.inertia *= self.mass * self.length * self.length;
        inertial.body_from_inertial = self.place(inertial.body_from_inertial);
    }

    /// Scales the numbers of a joint except its anchor.
    pub(crate) fn joint(&self, joint: &mut Joint) {
        let [length, mass] = self.similar;
        // A force in the direction of q, and a unit of q.
        let (force, unit, own_unit) = match joint.motion {
            JointType::Slide => (mass * length, self.length, length),
            _ => (mass * length * length, 1.0, 1.0),
        };
        for number in [
            &mut joint.reference,
            &mut joint.limits.lower,
            &mut joint.limits.upper,
            &mut joint.passive.rest,
            &mut joint.spring_yield,
        ] {
            *number *= unit;
        }
        joint.passive.friction *= force;
        joint.actuator_force_range = joint.actuator_force_range.map(|bound| bound * force);
        let passive = &mut joint.passive;
        for number in [
            &mut passive.stiffness,
            &mut passive.damping,
            &mut passive.armature,
            &mut joint.placement_stiffness,
        ] {
            *number *= force / own_unit;
        }
        for terms in [&mut joint.higher_terms.stiffness, &mut joint.higher_terms.damping] {
            terms[0] *= force / own_unit.powi(2);
            terms[1] *= force / own_unit.powi(3);
        }
    }
}

impl Reader<'_> {
    /// The factors in a frame, by those around it.
    pub(crate) fn frame_scale(&mut self, element: &Element, around: FrameScale) -> FrameScale {
        let factors = self.all_numbers(element, "scale").unwrap_or_else(|| vec![1.0]);
        let written = self.number(element, "massscale").unwrap_or(0.0);
        let is_similar = self.word(element, "scaling", &["similar", "geometry"]) != Some("geometry");
        let length = match factors[..] {
            [length] => length,
            [x, y, z] if x == y && y == z => x,
            [_, _, _] => {
                let message = "a frame with several scales: the stretch of its contents is not in the model";
                self.report_ignored_physics(element, message);
                return around;
            }
            _ => {
                self.refuse(element, "scale: 1 or 3 numbers are needed");
                return around;
            }
        };
        let is_valid = |factor: f64| factor > 0.0 && factor.is_finite();
        if !is_valid(length) || !(written == 0.0 || is_valid(written)) {
            self.refuse(element, "scale and massscale must be positive");
            return around;
        }
        let mass = if written > 0.0 { written } else { length.powi(3) };
        if length == 1.0 && mass == 1.0 {
            return around;
        }
        let others = ["actuator", "tendon", "equality", "keyframe"];
        let found: Vec<&str> =
            others.into_iter().filter(|section| self.tree.in_sections(section).next().is_some()).collect();
        if !found.is_empty() {
            let found = found.join(", ");
            let message = format!("the elements of {found} that refer to a scaled frame are not scaled");
            self.report_ignored_physics(element, message);
        }
        self.report_read(element, format!("lengths by {length}, masses by {mass}"));
        let [own_length, own_mass] = around.similar;
        let similar = if is_similar { [own_length * length, own_mass * mass] } else { around.similar };
        FrameScale { length: around.length * length, mass: around.mass * mass, similar }
    }
}
