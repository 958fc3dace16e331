//! `<keyframe>`.

use multibody::{JointDescription, JointKind, NamedPose, Quaternion};

use super::Writing;

impl Writing<'_> {
    pub(super) fn poses(&mut self) {
        let robot = self.robot;
        if robot.poses.is_empty() {
            return;
        }
        self.xml.start("keyframe");
        for pose in &robot.poses {
            let (mut q, mut v) = (Vec::new(), Vec::new());
            for &joint in &self.order {
                match joint {
                    Some(joint) => self.stretch(pose, &robot.joints[joint], &mut q, &mut v),
                    None => free(pose, &robot.floating_base_name(), &mut q, &mut v),
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

    /// A joint's numbers in the format's order: those of a follower from its leader's.
    fn stretch(&self, pose: &NamedPose, joint: &JointDescription, q: &mut Vec<f64>, v: &mut Vec<f64>) {
        match joint.kind {
            JointKind::Floating => free(pose, &joint.name, q, v),
            JointKind::Spherical => {
                let own = of(&pose.positions, &joint.name);
                let [x, y, z, w] = own.and_then(|own| own.try_into().ok()).unwrap_or([0.0, 0.0, 0.0, 1.0]);
                q.extend([w, x, y, z]);
                v.extend(padded(of(&pose.velocities, &joint.name), 3));
            }
            _ => {
                // A follower's are its leader's, times its ratio; leaders of leaders likewise.
                let (mut at, mut ratio, mut offset) = (joint, 1.0, 0.0);
                while let Some(mimic) = &at.mimic {
                    (offset, ratio) = (offset + ratio * mimic.offset, ratio * mimic.ratio);
                    let Some(leader) = self.robot.joints.iter().find(|own| own.name == mimic.joint) else {
                        break;
                    };
                    at = leader;
                }
                let count = joint.kind.nv();
                let (own_q, own_v) = (of(&pose.positions, &at.name), of(&pose.velocities, &at.name));
                q.extend(padded(own_q, count).map(|x| ratio * x + offset));
                v.extend(padded(own_v, count).map(|x| ratio * x));
            }
        }
    }
}

/// A free body's place and quaternion, w first, and its velocities: the linear one along the world's axes.
fn free(pose: &NamedPose, joint: &str, q: &mut Vec<f64>, v: &mut Vec<f64>) {
    let own = of(&pose.positions, joint).and_then(|own| <[f64; 7]>::try_from(own).ok());
    let [a, b, c, x, y, z, w] = own.unwrap_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    q.extend([a, b, c, w, x, y, z]);
    let own: Vec<f64> = padded(of(&pose.velocities, joint), 6).collect();
    let turn = Quaternion::from_xyzw([x, y, z, w]).normalized();
    v.extend(turn.rotate([own[0], own[1], own[2]]));
    v.extend(&own[3..]);
}

fn of<'p>(list: &'p [(String, Vec<f64>)], joint: &str) -> Option<&'p [f64]> {
    list.iter().find(|(name, _)| name == joint).map(|(_, own)| own.as_slice())
}

/// These numbers, zeros behind them.
fn padded(own: Option<&[f64]>, count: usize) -> impl Iterator<Item = f64> {
    let own = own.unwrap_or_default();
    own.iter().copied().chain(core::iter::repeat(0.0)).take(count)
}
