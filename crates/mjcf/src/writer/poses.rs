//! Writes `<keyframe>`.

use robot_dynamics_description::{JointDescription, JointKind, NamedPose, Quaternion};

use super::MjcfWriter;

impl MjcfWriter<'_> {
    pub(super) fn write_poses(&mut self) {
        let robot = self.robot;
        if robot.poses.is_empty() {
            return;
        }
        self.xml.start("keyframe");
        for pose in &robot.poses {
            let (mut q, mut v) = (Vec::new(), Vec::new());
            for &joint in &self.order {
                match joint {
                    Some(joint) => self.push_joint(pose, &robot.joints[joint], &mut q, &mut v),
                    None => push_free_joint(pose, &robot.floating_base_name(), &mut q, &mut v),
                }
            }
            self.xml.start("key").attribute("name", &pose.name).numbers("qpos", &q);
            if v.iter().any(|&v| v != 0.0) {
                self.xml.numbers("qvel", &v);
            }
            let controls: Vec<f64> =
                self.written_actuators.iter().filter_map(|&k| pose.controls.get(k).copied()).collect();
            if !controls.is_empty() && controls.len() == self.written_actuators.len() {
                self.xml.numbers("ctrl", &controls);
            }
            self.xml.end();
        }
        self.xml.end();
    }

    /// Adds the numbers of a joint in the order of MJCF. Those of a mimic joint follow from its leader.
    fn push_joint(&self, pose: &NamedPose, joint: &JointDescription, q: &mut Vec<f64>, v: &mut Vec<f64>) {
        match joint.kind {
            JointKind::Floating => push_free_joint(pose, &joint.name, q, v),
            JointKind::Spherical => {
                let own = numbers_of(&pose.positions, &joint.name);
                let [x, y, z, w] = own.and_then(|own| own.try_into().ok()).unwrap_or([0.0, 0.0, 0.0, 1.0]);
                q.extend([w, x, y, z]);
                v.extend(pad(numbers_of(&pose.velocities, &joint.name), 3));
            }
            _ => {
                // Composes the ratios and offsets along the chain of leaders.
                let (mut at, mut ratio, mut offset) = (joint, 1.0, 0.0);
                while let Some(mimic) = &at.mimic {
                    (offset, ratio) = (offset + ratio * mimic.offset, ratio * mimic.ratio);
                    let Some(leader) = self.robot.joints.iter().find(|own| own.name == mimic.joint) else {
                        break;
                    };
                    at = leader;
                }
                let count = joint.kind.nv();
                let (own_q, own_v) =
                    (numbers_of(&pose.positions, &at.name), numbers_of(&pose.velocities, &at.name));
                q.extend(pad(own_q, count).map(|x| ratio * x + offset));
                v.extend(pad(own_v, count).map(|x| ratio * x));
            }
        }
    }
}

/// Adds the position and quaternion (w first) of a free body, and its velocity with the linear part in world
/// axes.
fn push_free_joint(pose: &NamedPose, joint: &str, q: &mut Vec<f64>, v: &mut Vec<f64>) {
    let own = numbers_of(&pose.positions, joint).and_then(|own| <[f64; 7]>::try_from(own).ok());
    let [a, b, c, x, y, z, w] = own.unwrap_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    q.extend([a, b, c, w, x, y, z]);
    let own: Vec<f64> = pad(numbers_of(&pose.velocities, joint), 6).collect();
    let turn = Quaternion::from_xyzw([x, y, z, w]).normalized();
    v.extend(turn.rotate([own[0], own[1], own[2]]));
    v.extend(&own[3..]);
}

fn numbers_of<'p>(list: &'p [(String, Vec<f64>)], joint: &str) -> Option<&'p [f64]> {
    list.iter().find(|(name, _)| name == joint).map(|(_, own)| own.as_slice())
}

/// The numbers, followed by zeros.
fn pad(own: Option<&[f64]>, count: usize) -> impl Iterator<Item = f64> {
    let own = own.unwrap_or_default();
    own.iter().copied().chain(core::iter::repeat(0.0)).take(count)
}
