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
            let (ratio, offset, leader) = match &joint.mimic {
                Some(mimic) => {
                    let leader = model.joints().iter().find(|joint| joint.name == mimic.joint);
                    (mimic.ratio, mimic.offset, leader.unwrap_or(joint))
                }
                None => (1.0, 0.0, joint),
            };
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
