//! A pose that a robot's file names, as a state.

use crate::{Model, neutral};

impl Model {
    /// (q, v) of a pose that the robot's file names; `None` where there is none of that name. Joints that are not in it,
    /// locked ones among them, are left at neutral.
    pub fn named_pose(&self, name: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        let pose = self.description.poses.iter().find(|pose| pose.name == name)?;
        let (mut q, mut v) = (neutral(self), vec![0.0; self.nv()]);
        for (joint, numbers) in &pose.positions {
            let found = self.joints.iter().find(|own| own.name == *joint && own.nq == numbers.len());
            if let Some(own) = found {
                q[own.q_index..own.q_index + own.nq].copy_from_slice(numbers);
            }
        }
        for (joint, numbers) in &pose.velocities {
            let found = self.joints.iter().find(|own| own.name == *joint && own.nv == numbers.len());
            if let Some(own) = found {
                v[own.v_index..own.v_index + own.nv].copy_from_slice(numbers);
            }
        }
        Some((q, v))
    }
}
