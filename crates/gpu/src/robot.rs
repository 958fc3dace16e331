//! What the processor knows of a robot whose functions run on a device: sizes, and which configurations are none.

use multibody::{Measure, Model};

use crate::DeviceFloat;

/// An angle that generated code takes the sine of: ratio · q + offset of the entry `q`.
#[derive(Clone, Copy, Debug)]
struct Angle {
    q: usize,
    ratio: f64,
    offset: f64,
}

/// A robot as the processor's checks need it.
#[derive(Clone, Debug)]
pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
    /// Whether a joint has damping or friction.
    pub(crate) dissipates: bool,
    angles: Vec<Angle>,
    /// Where quaternions begin in q.
    quaternions: Vec<usize>,
}

impl Robot {
    pub(crate) fn new(model: &Model) -> Self {
        let (mut angles, mut quaternions) = (Vec::new(), Vec::new());
        for joint in model.joints() {
            // A leader may follow another: k₁ (k₂ q + c₂) + c₁.
            let (mut ratio, mut offset, mut leader) = (1.0, 0.0, joint);
            while let Some(mimic) = &leader.mimic
                && let Some(next) = model.joints().iter().find(|joint| joint.name == mimic.joint)
            {
                (ratio, offset, leader) = (ratio * mimic.ratio, offset + ratio * mimic.offset, next);
            }
            let positions = joint.kind.positions();
            for (k, position) in positions.iter().enumerate() {
                match position.measure {
                    Measure::Angle => angles.push(Angle { q: leader.q_index + k, ratio, offset }),
                    Measure::Quaternion if k == 0 || positions[k - 1].measure != Measure::Quaternion => {
                        quaternions.push(joint.q_index + k);
                    }
                    _ => {}
                }
            }
        }
        let passive = model.description().joints.iter().map(|joint| &joint.passive);
        let dissipates = passive.into_iter().any(|passive| passive.damping != 0.0 || passive.friction != 0.0);
        Self { name: model.name().into(), nq: model.nq(), nv: model.nv(), dissipates, angles, quaternions }
    }

    /// Whether generated code has a value at q: no quaternion is zero, no angle beyond the range of its sine. What is not finite
    /// is looked for elsewhere.
    pub(crate) fn has_value_at<T: DeviceFloat>(&self, q: &[T]) -> bool {
        let is_zero = |&first: &usize| q[first..first + 4].iter().all(|x| x.wide() == 0.0);
        let is_within =
            |angle: &Angle| (angle.ratio * q[angle.q].wide() + angle.offset).abs() < T::MOST_ANGLE;
        !self.quaternions.iter().any(is_zero) && self.angles.iter().all(is_within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use multibody::{JointDescription, JointKind, LinkDescription, Mimic, Pose, pendulum};

    /// A wheel follows a slide, and another joint the wheel: its angle is in the range or not where the slide is at some 200 m.
    #[test]
    fn a_follower_of_a_follower_counts() {
        let mut robot = pendulum(2.0, 0.5);
        let axis = [0.0, 0.0, 1.0];
        let mut add = |name: &str, kind: JointKind, mimic: Option<Mimic>| {
            robot.links.push(LinkDescription::new(format!("link of {name}"), robot.links[1].mass_properties));
            let child = format!("link of {name}");
            let mut joint = JointDescription::new(name, kind, "rod", child, Pose::IDENTITY);
            joint.mimic = mimic;
            robot.joints.push(joint);
        };
        let follow = |joint: &str, ratio: f64, offset: f64| Some(Mimic::new(joint, ratio, offset));
        add("slide", JointKind::Prismatic { axis }, None);
        add("wheel", JointKind::Revolute { axis }, follow("slide", 20.0, 1.0));
        add("last", JointKind::Revolute { axis }, follow("wheel", -2.0, 6.0));
        let model = Model::new(robot).unwrap();
        let robot = Robot::new(&model);
        assert_eq!(model.nq(), 2);
        // −2 (20 q + 1) + 6 = 4 − 40 q.
        for (q, expected) in [(204.89, true), (204.91, false), (-204.69, true), (-204.71, false)] {
            assert_eq!(robot.has_value_at(&[0.0_f32, q]), expected, "{q}");
        }
        assert!(robot.has_value_at(&[0.0_f64, 2000.0]) && !robot.has_value_at(&[1e5_f64, 0.0]));
    }
}
