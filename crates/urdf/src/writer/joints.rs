//! Writes `<joint>`, and `<origin>` by roll, pitch and yaw.

use robot_dynamics_description::{JointDescription, JointKind, Limits, PassiveForces, Pose};

use super::{UrdfWriter, joint_place};

impl UrdfWriter<'_> {
    pub(super) fn write_joint(&mut self, joint: &JointDescription) {
        let place = joint_place(&joint.name);
        let (word, axis) = match joint.kind {
            JointKind::Fixed => ("fixed", None),
            JointKind::Revolute { axis } => ("revolute", Some(axis)),
            JointKind::Continuous { axis } => ("continuous", Some(axis)),
            JointKind::Prismatic { axis } => ("prismatic", Some(axis)),
            JointKind::Planar { normal } => ("planar", Some(normal)),
            JointKind::Floating => ("floating", None),
            JointKind::Spherical => {
                self.add_note(&place, "few other programs read type=\"spherical\"");
                ("spherical", None)
            }
            kind => {
                self.unwritable.push(format!("{place}: URDF has no {} joints", kind.name()));
                return;
            }
        };
        self.xml.start("joint").attribute("name", &joint.name).attribute("type", word);
        self.write_origin(&joint.parent_from_joint);
        self.xml.start("parent").attribute("link", &joint.parent).end();
        self.xml.start("child").attribute("link", &joint.child).end();
        if let Some(axis) = axis {
            self.xml.start("axis").numbers("xyz", &axis).end();
        }
        if joint.kind != JointKind::Fixed {
            self.write_limit(&place, joint);
            self.write_dynamics(&place, &joint.passive);
            if !joint.higher_terms.is_zero() {
                self.add_loss(&place, "nonlinear terms of a spring or damper: not supported by URDF");
            }
            if joint.spring_yield != 0.0 {
                self.add_loss(&place, "the yield of its spring: not supported by URDF");
            }
            if joint.spring.is_some() {
                self.add_loss(&place, "the spring of a ball or free joint: not supported by URDF");
            }
        }
        if let Some(mimic) = &joint.mimic {
            self.xml.start("mimic").attribute("joint", &mimic.joint);
            self.xml.numbers("multiplier", &[mimic.ratio]).numbers("offset", &[mimic.offset]).end();
        }
        self.xml.end();
    }

    /// Writes `<origin>`, which is omitted for the identity.
    pub(super) fn write_origin(&mut self, pose: &Pose) {
        if *pose == Pose::IDENTITY {
            return;
        }
        self.xml.start("origin").numbers("xyz", &pose.translation);
        self.xml.numbers("rpy", &roll_pitch_yaw(&pose.rotation)).end();
    }

    fn write_limit(&mut self, place: &str, joint: &JointDescription) {
        let Limits { lower, upper, velocity, effort, .. } = joint.limits;
        let is_bounded = matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
        if !is_bounded && (lower.is_finite() || upper.is_finite()) {
            let message =
                format!("bounds {lower} and {upper}: not supported by URDF for {} joints", joint.kind.name());
            self.add_loss(place, message);
        }
        let [least, most] = joint.actuator_force_range;
        // The effort is the larger of the two bounds, as in the readers.
        let effort = effort.min(least.abs().max(most.abs()));
        #[allow(clippy::float_cmp)] // the same bound on both sides, or not
        if -least != most {
            let message = format!("actuator forces from {least} to {most}: URDF has only symmetric bounds");
            self.add_loss(place, message);
        }
        if is_bounded || velocity.is_finite() || effort.is_finite() {
            self.xml.start("limit");
            if is_bounded {
                self.write_bound("lower", lower);
                self.write_bound("upper", upper);
            }
            self.write_bound("effort", effort);
            self.write_bound("velocity", velocity);
            self.xml.end();
        }
    }

    /// Writes a bound. Readers require every bound, so the largest double stands for "no bound".
    fn write_bound(&mut self, name: &str, bound: f64) {
        self.xml.numbers(name, &[bound.clamp(-f64::MAX, f64::MAX)]);
    }

    fn write_dynamics(&mut self, place: &str, passive: &PassiveForces) {
        let PassiveForces { armature, damping, friction, stiffness, rest, .. } = *passive;
        if [armature, damping, friction, stiffness, rest] == [0.0; 5] {
            return;
        }
        self.xml.start("dynamics").numbers("damping", &[damping]).numbers("friction", &[friction]);
        self.xml.unless("armature", armature, 0.0).unless("stiffness", stiffness, 0.0);
        self.xml.unless("rest", rest, 0.0).end();
        if armature != 0.0 || stiffness != 0.0 {
            let message = "armature and spring are attributes of <dynamics>, which few other programs read";
            self.add_note(place, message);
        }
    }
}

/// The angles of R = Rz(yaw) Ry(pitch) Rx(roll) \[rad\]. Each angle is computed after the rotation by the one
/// before it is removed, so that R is reproduced to rounding even where the angles are not unique.
fn roll_pitch_yaw(r: &[[f64; 3]; 3]) -> [f64; 3] {
    // Here x points up or down to rounding, and the yaw is arbitrary.
    let yaw = if r[0][0].hypot(r[1][0]) < 1e-15 { 0.0 } else { r[1][0].atan2(r[0][0]) };
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r[2][0]).atan2(cos * r[0][0] + sin * r[1][0]);
    let roll = (sin * r[0][2] - cos * r[1][2]).atan2(cos * r[1][1] - sin * r[0][1]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use robot_dynamics_description::Pose;

    use super::roll_pitch_yaw;

    /// The pitches include ±90° and angles close to them.
    #[test]
    fn angles_give_the_rotation_back() {
        let mut worst = 0.0_f64;
        for pitch in [0.0, 0.3, -1.2, FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2 - 1e-8, -FRAC_PI_2 + 1e-13] {
            for roll in [0.0, 0.7, -2.9, FRAC_PI_2] {
                for yaw in [0.0, -0.4, 3.1, 2.0 * FRAC_PI_2] {
                    let there = Pose::from_xyz_rpy([0.0; 3], [roll, pitch, yaw]).rotation;
                    let back = Pose::from_xyz_rpy([0.0; 3], roll_pitch_yaw(&there)).rotation;
                    let off = there.iter().flatten().zip(back.iter().flatten()).map(|(a, b)| (a - b).abs());
                    worst = off.fold(worst, f64::max);
                }
            }
        }
        assert!(worst < 2e-15, "{worst:e}");
    }
}
