//! `<joint>`, and placements by roll, pitch and yaw.

use multibody::{JointDescription, JointKind, Limits, PassiveForces, Pose};

use super::{Writing, joint_place};

impl Writing<'_> {
    pub(super) fn joint(&mut self, joint: &JointDescription) {
        let place = joint_place(&joint.name);
        let (word, axis) = match joint.kind {
            JointKind::Fixed => ("fixed", None),
            JointKind::Revolute { axis } => ("revolute", Some(axis)),
            JointKind::Continuous { axis } => ("continuous", Some(axis)),
            JointKind::Prismatic { axis } => ("prismatic", Some(axis)),
            JointKind::Planar { normal } => ("planar", Some(normal)),
            JointKind::Floating => ("floating", None),
            JointKind::Spherical => {
                self.note(&place, "type=\"spherical\" is read by this library and by few other programs");
                ("spherical", None)
            }
            kind => {
                self.unwritable.push(format!("{place}: the format has no {} joints", kind.name()));
                return;
            }
        };
        self.xml.start("joint").attribute("name", &joint.name).attribute("type", word);
        self.origin(&joint.parent_from_joint);
        self.xml.start("parent").attribute("link", &joint.parent).end();
        self.xml.start("child").attribute("link", &joint.child).end();
        if let Some(axis) = axis {
            self.xml.start("axis").numbers("xyz", &axis).end();
        }
        if joint.kind != JointKind::Fixed {
            self.limit(&place, joint);
            self.dynamics(&place, &joint.passive);
            if !joint.higher_terms.is_zero() {
                self.lost(&place, "a spring or damper with more than linear terms: the format has none");
            }
            if joint.spring.is_some() {
                self.lost(&place, "the spring of a joint that turns freely: the format has none");
            }
        }
        if let Some(mimic) = &joint.mimic {
            self.xml.start("mimic").attribute("joint", &mimic.joint);
            self.xml.numbers("multiplier", &[mimic.ratio]).numbers("offset", &[mimic.offset]).end();
        }
        self.xml.end();
    }

    /// Nothing where the frames are one.
    pub(super) fn origin(&mut self, pose: &Pose) {
        if *pose == Pose::IDENTITY {
            return;
        }
        self.xml.start("origin").numbers("xyz", &pose.translation);
        self.xml.numbers("rpy", &roll_pitch_yaw(&pose.rotation)).end();
    }

    fn limit(&mut self, place: &str, joint: &JointDescription) {
        let Limits { lower, upper, velocity, effort, .. } = joint.limits;
        let is_bounded = matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
        if !is_bounded && (lower.is_finite() || upper.is_finite()) {
            let message =
                format!("bounds {lower} and {upper}: a {} joint has none in the format", joint.kind.name());
            self.lost(place, message);
        }
        let [least, most] = joint.actuator_force_range;
        // What its reader makes of bounds on forces: the larger of both is its effort.
        let effort = effort.min(least.abs().max(most.abs()));
        #[allow(clippy::float_cmp)] // the same bound on both sides, or not
        if -least != most {
            let message =
                format!("forces of its actuators from {least} to {most}: the format bounds both sides alike");
            self.lost(place, message);
        }
        if is_bounded || velocity.is_finite() || effort.is_finite() {
            self.xml.start("limit");
            if is_bounded {
                self.bound("lower", lower);
                self.bound("upper", upper);
            }
            self.bound("effort", effort);
            self.bound("velocity", velocity);
            self.xml.end();
        }
    }

    /// Readers want every bound; the largest of all numbers stands for none.
    fn bound(&mut self, name: &str, bound: f64) {
        self.xml.numbers(name, &[bound.clamp(-f64::MAX, f64::MAX)]);
    }

    fn dynamics(&mut self, place: &str, passive: &PassiveForces) {
        let PassiveForces { armature, damping, friction, stiffness, rest, .. } = *passive;
        if [armature, damping, friction, stiffness, rest] == [0.0; 5] {
            return;
        }
        self.xml.start("dynamics").numbers("damping", &[damping]).numbers("friction", &[friction]);
        self.xml.unless("armature", armature, 0.0).unless("stiffness", stiffness, 0.0);
        self.xml.unless("rest", rest, 0.0).end();
        if armature != 0.0 || stiffness != 0.0 {
            let message = "armature and spring are attributes of <dynamics> that this library reads, and few other programs";
            self.note(place, message);
        }
    }
}

/// The angles of R = Rz(yaw) Ry(pitch) Rx(roll) \[rad\]. Each is taken of what is left when the one before it is turned back,
/// so that R comes back to rounding wherever the angles themselves are not determined.
fn roll_pitch_yaw(r: &[[f64; 3]; 3]) -> [f64; 3] {
    // Below rounding the first column has no direction: x points up or down, and any yaw serves.
    let yaw = if r[0][0].hypot(r[1][0]) < 1e-15 { 0.0 } else { r[1][0].atan2(r[0][0]) };
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r[2][0]).atan2(cos * r[0][0] + sin * r[1][0]);
    let roll = (sin * r[0][2] - cos * r[1][2]).atan2(cos * r[1][1] - sin * r[0][1]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use multibody::Pose;

    use super::roll_pitch_yaw;

    /// Also where x points up, and next to it.
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
