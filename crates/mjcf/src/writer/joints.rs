//! Writes `<joint>` and `<freejoint>`.

use robot_dynamics_description::{JointDescription, JointKind, PassiveForces, Pose, SolverImpedance};

use super::chain::WrittenBody;
use super::{MjcfWriter, joint_place};

/// A joint of the file: its type, and its axis in the frame of the joint.
type FileJoint = (&'static str, Option<[f64; 3]>);

/// The joints of the file that represent a joint.
pub(super) fn file_joints(kind: &JointKind) -> Vec<FileJoint> {
    match *kind {
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => vec![("hinge", Some(axis))],
        JointKind::Prismatic { axis } => vec![("slide", Some(axis))],
        JointKind::Universal { first, second } => vec![("hinge", Some(first)), ("hinge", Some(second))],
        JointKind::Planar { normal } => {
            let [x, y] = planar_axes(normal);
            vec![("slide", Some(x)), ("slide", Some(y)), ("hinge", Some(normal))]
        }
        JointKind::Spherical => vec![("ball", None)],
        JointKind::Floating => vec![("free", None)],
        // A body without a joint is fixed. Helical joints are refused before.
        JointKind::Fixed | JointKind::Helical { .. } => Vec::new(),
    }
}

/// The two translation axes of a planar joint: see [`JointKind::Planar`].
fn planar_axes(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let [a, b, c] = normal.map(f64::abs);
    let largest = if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    };
    let n = nalgebra::Vector3::from(normal).normalize();
    let mut next = nalgebra::Vector3::zeros();
    next[(largest + 1) % 3] = 1.0;
    let x = (next - n * n.dot(&next)).normalize();
    [x.into(), n.cross(&x).into()]
}

impl MjcfWriter<'_> {
    /// The names of the joints of the file that represent a joint.
    pub(super) fn file_joint_names(joint: &JointDescription) -> Vec<String> {
        if matches!(joint.kind, JointKind::Spherical | JointKind::Floating) {
            return vec![joint.name.clone()];
        }
        joint.kind.positions().iter().map(|position| position.of_joint(&joint.name)).collect()
    }

    pub(super) fn write_joints(&mut self, body: &WrittenBody) {
        let robot = self.robot;
        if body.joints.is_empty() && robot.base == robot_dynamics_description::Base::Floating {
            let name = self.joint_names.unique(&robot.floating_base_name());
            self.xml.start("freejoint").attribute("name", &name).end();
            self.order.push(None);
        }
        for (at, &index) in body.joints.iter().enumerate() {
            let joint = &robot.joints[index];
            // The frame of the joint in the body, with all joints at zero.
            let rest = body.joints[at + 1..].iter();
            let joint_from_body =
                rest.fold(Pose::IDENTITY, |pose, &next| pose.compose(&robot.joints[next].parent_from_joint));
            let body_from_joint = joint_from_body.inverse();
            if joint.kind != JointKind::Fixed {
                self.order.push(Some(index));
            }
            for ((word, axis), name) in
                file_joints(&joint.kind).into_iter().zip(Self::file_joint_names(joint))
            {
                let is_plain = joint.passive == PassiveForces::default()
                    && joint.spring.is_none()
                    && joint.higher_terms.is_zero();
                if word == "free" && is_plain {
                    self.xml.start("freejoint").attribute("name", &name).end();
                    continue;
                }
                self.xml.start("joint").attribute("name", &name);
                if word != "hinge" {
                    self.xml.attribute("type", word);
                }
                if word != "free" && body_from_joint.translation != [0.0; 3] {
                    self.xml.numbers("pos", &body_from_joint.translation);
                }
                if let Some(axis) = axis {
                    self.xml.numbers("axis", &body_from_joint.rotate(axis));
                }
                self.write_properties(joint, axis.is_some());
                self.xml.end();
            }
        }
    }

    /// Writes the softness of limits or friction, unless it is MuJoCo's default.
    pub(super) fn write_softness(&mut self, of: &str, softness: &SolverImpedance) {
        let usual = SolverImpedance::default();
        if softness.solref != usual.solref {
            self.xml.numbers(&format!("solref{of}"), &softness.solref);
        }
        if softness.solimp != usual.solimp {
            self.xml.numbers(&format!("solimp{of}"), &softness.solimp);
        }
    }

    /// Writes a polynomial without trailing zeros: one coefficient if it is linear.
    pub(super) fn write_polynomial(&mut self, name: &str, linear: f64, higher: [f64; 2]) {
        if higher == [0.0; 2] {
            self.xml.unless(name, linear, 0.0);
        } else {
            self.xml.numbers(name, &[linear, higher[0], higher[1]]);
        }
    }

    fn write_properties(&mut self, joint: &JointDescription, is_single: bool) {
        let place = joint_place(&joint.name);
        let limits = &joint.limits;
        let range = [limits.lower, limits.upper];
        if is_single {
            self.write_range(&place, "range", range);
        } else if range.iter().any(|bound| bound.is_finite()) {
            self.add_loss(&place, format!("position bounds {range:?}: not supported by MJCF for its type"));
        }
        if joint.kind == JointKind::Spherical && limits.turn.is_finite() {
            self.write_range(&place, "range", [0.0, limits.turn]);
        }
        let PassiveForces { armature, damping, friction, stiffness, rest, .. } = joint.passive;
        let spring = joint.spring.unwrap_or_default();
        if joint.kind == JointKind::Spherical && spring.rest.rotation != Pose::IDENTITY.rotation {
            self.add_loss(&place, "the rest pose of its spring becomes the pose of the file");
        }
        self.write_polynomial("stiffness", stiffness + spring.stiffness, joint.higher_terms.stiffness);
        self.write_polynomial("damping", damping, joint.higher_terms.damping);
        self.xml.unless("springyield", joint.spring_yield, 0.0);
        self.xml.unless("springref", rest, 0.0).unless("armature", armature, 0.0);
        self.xml.unless("frictionloss", friction, 0.0);
        self.write_softness("limit", &joint.softness.limit);
        self.write_softness("friction", &joint.softness.friction);
        self.xml.unless("margin", joint.softness.margin, 0.0);
        if joint.actuator_compensates_gravity {
            self.xml.attribute("actuatorgravcomp", "true");
        }
        let forces = if joint.actuator_force_range == [f64::NEG_INFINITY, f64::INFINITY] {
            [-limits.effort, limits.effort]
        } else {
            joint.actuator_force_range
        };
        if is_single && forces[0] < forces[1] {
            self.write_range(&place, "actuatorfrcrange", forces);
        } else if forces.iter().any(|bound| bound.is_finite()) {
            self.add_note(&place, format!("bounds {forces:?} on its actuator forces: not supported by MJCF"));
        }
        if limits.velocity.is_finite() {
            self.add_note(&place, format!("a velocity bound of {}: not supported by MJCF", limits.velocity));
        }
    }
}
