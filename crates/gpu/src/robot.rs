//! Properties of a robot for the checks on the CPU: sizes, and the valid configurations.

use robot_dynamics::description::CoordinateKind;
use robot_dynamics::model::Model;

use crate::DeviceFloat;

/// An angle whose sine generated code computes: ratio · q + offset of the entry `q`.
#[derive(Clone, Copy, Debug)]
struct Angle {
    q: usize,
    ratio: f64,
    offset: f64,
}

/// Whether a predicate holds for all numbers. Evaluating it without an early exit lets the compiler vectorise
/// the loop.
fn all_numbers<T: DeviceFloat>(numbers: &[T], is_such: impl Fn(&T) -> bool) -> bool {
    numbers.iter().fold(true, |all, x| all & is_such(x))
}

/// Marks the states with a number that is not finite in their table.
pub(crate) fn mark_not_finite<T: DeviceFloat>(rows: &[T], is_bad: &mut [bool]) {
    if all_numbers(rows, |x| x.is_finite()) {
        return;
    }
    for (row, is_bad) in rows.chunks(rows.len() / is_bad.len()).zip(is_bad) {
        *is_bad |= !row.iter().all(|x| x.is_finite());
    }
}

/// The numbers of the marked states, counted from `first`.
pub(crate) fn marked_states(is_bad: &[bool], first: usize) -> impl Iterator<Item = usize> {
    is_bad.iter().enumerate().filter(|(_, is_bad)| **is_bad).map(move |(state, _)| first + state)
}

/// Properties of a robot for the checks on the CPU.
#[derive(Clone, Debug)]
pub(crate) struct RobotConstants {
    pub(crate) name: String,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
    /// Whether a joint has damping or friction.
    pub(crate) dissipates: bool,
    angles: Vec<Angle>,
    /// The indices at which quaternions begin in q.
    quaternions: Vec<usize>,
}

impl RobotConstants {
    pub(crate) fn new(model: &Model) -> Self {
        let (mut angles, mut quaternions) = (Vec::new(), Vec::new());
        for joint in model.joints() {
            // The leader of a mimic joint may be a mimic joint itself: k₁ (k₂ q + c₂) + c₁.
            let (mut ratio, mut offset, mut leader) = (1.0, 0.0, joint);
            while let Some(mimic) = &leader.mimic
                && let Some(next) = model.joints().iter().find(|joint| joint.name == mimic.joint)
            {
                (ratio, offset, leader) = (ratio * mimic.ratio, offset + ratio * mimic.offset, next);
            }
            let positions = joint.kind.positions();
            for (k, position) in positions.iter().enumerate() {
                match position.kind {
                    CoordinateKind::Angle => angles.push(Angle { q: leader.q_index + k, ratio, offset }),
                    CoordinateKind::Quaternion
                        if k == 0 || positions[k - 1].kind != CoordinateKind::Quaternion =>
                    {
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

    /// Marks the states for which generated code has no value: a quaternion is zero, or an angle is beyond
    /// the range of its sine. Numbers that are not finite are checked elsewhere.
    pub(crate) fn mark_invalid<T: DeviceFloat>(&self, q: &[T], is_bad: &mut [bool]) {
        let are_angles_small = self.are_angles_small(q);
        if are_angles_small && self.quaternions.is_empty() {
            return;
        }
        for (q, is_bad) in q.chunks(self.nq).zip(is_bad) {
            let is_zero = |&first: &usize| q[first..first + 4].iter().all(|x| x.wide() == 0.0);
            let is_within =
                |angle: &Angle| (angle.ratio * q[angle.q].wide() + angle.offset).abs() < T::MOST_ANGLE;
            *is_bad |= self.quaternions.iter().any(is_zero)
                || (!are_angles_small && !self.angles.iter().all(is_within));
        }
    }

    /// Whether all numbers are so small that no angle is beyond the range. This is the common case, and one
    /// pass over the whole table is cheaper than a check of each angle of each state.
    fn are_angles_small<T: DeviceFloat>(&self, q: &[T]) -> bool {
        let most = |of: fn(&Angle) -> f64| self.angles.iter().map(of).fold(0.0, f64::max);
        let ratio = most(|angle| angle.ratio.abs()).max(1.0);
        // A margin of a millionth for rounding on either side.
        let limit = (1.0 - 1e-6) * (T::MOST_ANGLE - most(|angle| angle.offset.abs())) / ratio;
        all_numbers(q, |x| x.wide().abs() < limit)
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics::description::{
        Base, JointDescription, JointKind, LinkDescription, Mimic, Pose, pendulum,
    };

    use super::*;

    fn bad<T: DeviceFloat>(robot: &RobotConstants, q: &[T]) -> Vec<usize> {
        let mut is_bad = vec![false; q.len() / robot.nq];
        robot.mark_invalid(q, &mut is_bad);
        marked_states(&is_bad, 0).collect()
    }

    /// A wheel mimics a slide, and another joint mimics the wheel. Its angle is in the range or not when the
    /// slide is at about 200 m.
    #[test]
    fn a_mimic_joint_of_a_mimic_joint_is_checked() {
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
        let robot = RobotConstants::new(&model);
        assert_eq!(model.nq(), 2);
        // −2 (20 q + 1) + 6 = 4 − 40 q.
        for (q, expected) in [(204.89, true), (204.91, false), (-204.69, true), (-204.71, false)] {
            assert_eq!(bad(&robot, &[0.0_f32, q, 0.0, 1.0]), if expected { vec![] } else { vec![0] }, "{q}");
        }
        assert_eq!(bad(&robot, &[0.0_f64, 2000.0, 1e5, 0.0, -1e5, 0.0, 9e4, 1.0]), [1, 2]);
    }

    /// A floating robot's quaternion, and a number that is not finite in a table, beside valid states.
    #[test]
    fn each_state_is_checked_separately() {
        let mut description = pendulum(2.0, 0.5);
        description.base = Base::Floating;
        let robot = RobotConstants::new(&Model::new(description).unwrap());
        let good: [f32; 8] = [7.0, 8.0, 9.0, 0.0, 0.0, 1.0, 0.0, 0.5];
        assert_eq!(robot.nq, good.len());
        let mut q = [good; 5].concat();
        assert!(bad(&robot, &q).is_empty());
        q[8 + 5] = 0.0; // the quaternion of the second
        assert_eq!(bad(&robot, &q), [1]);
        q[2 * 8 + 7] = 1e4; // the angle of the third
        q[3 * 8] = 1e6; // a position, which is unlimited
        assert_eq!(bad(&robot, &q), [1, 2]);
        let mut is_bad = [false; 3];
        mark_not_finite(&[0.0, 1.0, 2.0, f32::NAN, f32::NEG_INFINITY, 3.0], &mut is_bad);
        mark_not_finite(&[0.0_f32; 3], &mut is_bad);
        mark_not_finite::<f32>(&[], &mut is_bad);
        assert_eq!(marked_states(&is_bad, 10).collect::<Vec<_>>(), [11, 12]);
    }
}
