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

/// Whether every number is such. It looks at all of them: without an early end at several at once.
fn every<T: DeviceFloat>(numbers: &[T], is_such: impl Fn(&T) -> bool) -> bool {
    numbers.iter().fold(true, |all, x| all & is_such(x))
}

/// Notes the states with a number that is not finite, in a table of theirs.
pub(crate) fn note_not_finite<T: DeviceFloat>(rows: &[T], is_bad: &mut [bool]) {
    if every(rows, |x| x.is_finite()) {
        return;
    }
    for (row, is_bad) in rows.chunks(rows.len() / is_bad.len()).zip(is_bad) {
        *is_bad |= !row.iter().all(|x| x.is_finite());
    }
}

/// The numbers of the states that were noted, counted from `first`.
pub(crate) fn noted(is_bad: &[bool], first: usize) -> impl Iterator<Item = usize> {
    is_bad.iter().enumerate().filter(|(_, is_bad)| **is_bad).map(move |(state, _)| first + state)
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

    /// Notes the states at whose q generated code has no value: a quaternion is zero, or an angle beyond the range of its sine. What
    /// is not finite is looked for elsewhere.
    pub(crate) fn note_without_value<T: DeviceFloat>(&self, q: &[T], is_bad: &mut [bool]) {
        let are_small = self.are_small(q);
        if are_small && self.quaternions.is_empty() {
            return;
        }
        for (q, is_bad) in q.chunks(self.nq).zip(is_bad) {
            let is_zero = |&first: &usize| q[first..first + 4].iter().all(|x| x.wide() == 0.0);
            let is_within =
                |angle: &Angle| (angle.ratio * q[angle.q].wide() + angle.offset).abs() < T::MOST_ANGLE;
            *is_bad |=
                self.quaternions.iter().any(is_zero) || (!are_small && !self.angles.iter().all(is_within));
        }
    }

    /// Whether numbers are so small that no angle of them is beyond the range: mostly they are, and one look at a whole table is
    /// cheaper than one at each angle of each state.
    fn are_small<T: DeviceFloat>(&self, q: &[T]) -> bool {
        let most = |of: fn(&Angle) -> f64| self.angles.iter().map(of).fold(0.0, f64::max);
        let ratio = most(|angle| angle.ratio.abs()).max(1.0);
        // A millionth less, for what rounding does to either side.
        let limit = (1.0 - 1e-6) * (T::MOST_ANGLE - most(|angle| angle.offset.abs())) / ratio;
        every(q, |x| x.wide().abs() < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use multibody::{Base, JointDescription, JointKind, LinkDescription, Mimic, Pose, pendulum};

    fn bad<T: DeviceFloat>(robot: &Robot, q: &[T]) -> Vec<usize> {
        let mut is_bad = vec![false; q.len() / robot.nq];
        robot.note_without_value(q, &mut is_bad);
        noted(&is_bad, 0).collect()
    }

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
            assert_eq!(bad(&robot, &[0.0_f32, q, 0.0, 1.0]), if expected { vec![] } else { vec![0] }, "{q}");
        }
        assert_eq!(bad(&robot, &[0.0_f64, 2000.0, 1e5, 0.0, -1e5, 0.0, 9e4, 1.0]), [1, 2]);
    }

    /// A free robot's quaternion, and a number that is not finite in some table, beside states that are right.
    #[test]
    fn each_state_is_judged_by_itself() {
        let mut description = pendulum(2.0, 0.5);
        description.base = Base::Floating;
        let robot = Robot::new(&Model::new(description).unwrap());
        let good: [f32; 8] = [7.0, 8.0, 9.0, 0.0, 0.0, 1.0, 0.0, 0.5];
        assert_eq!(robot.nq, good.len());
        let mut q = [good; 5].concat();
        assert!(bad(&robot, &q).is_empty());
        q[8 + 5] = 0.0; // the quaternion of the second
        assert_eq!(bad(&robot, &q), [1]);
        q[2 * 8 + 7] = 1e4; // the angle of the third
        q[3 * 8] = 1e6; // a place, which may be anywhere
        assert_eq!(bad(&robot, &q), [1, 2]);
        let mut is_bad = [false; 3];
        note_not_finite(&[0.0, 1.0, 2.0, f32::NAN, f32::NEG_INFINITY, 3.0], &mut is_bad);
        note_not_finite(&[0.0_f32; 3], &mut is_bad);
        note_not_finite::<f32>(&[], &mut is_bad);
        assert_eq!(noted(&is_bad, 10).collect::<Vec<_>>(), [11, 12]);
    }
}
