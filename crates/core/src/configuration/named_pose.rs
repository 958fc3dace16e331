//! Named poses of a robot's file, as states.

use crate::{Model, neutral};

/// The name of the pose in which an MJCF file places its bodies, if that is not the neutral one.
const PLACED: &str = "qpos0";

impl Model {
    /// The configuration in which the robot's file places its bodies: the pose `qpos0` of an MJCF file, else
    /// the neutral one.
    ///
    /// A simulation starts there by default.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, LinkDescription, NamedPose, RobotDescription};
    /// use robot_dynamics::model::Model;
    /// let mut robot = RobotDescription::new("drone");
    /// robot.links.push(LinkDescription::new("body", None));
    /// robot.base = Base::Floating;
    /// let placed = vec![0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0];
    /// assert_eq!(Model::new(robot.clone())?.initial_configuration()[2], 0.0);
    /// robot.poses.push(NamedPose::new("qpos0", [("floating_base".into(), placed.clone())]));
    /// assert_eq!(Model::new(robot)?.initial_configuration(), placed);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn initial_configuration(&self) -> Vec<f64> {
        self.named_pose(PLACED).map_or_else(|| neutral(self), |(q, _)| q)
    }

    /// (q, v) of a pose that the robot's file names; `None` if there is no pose of that name. Joints without
    /// a value in it, including locked ones, are neutral.
    pub fn named_pose(&self, name: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        let pose = self.description.poses.iter().find(|pose| pose.name == name)?;
        let (mut q, mut v) = (neutral(self), vec![0.0; self.nv()]);
        for (joint, numbers) in &pose.positions {
            let found = self.joints.iter().find(|own| own.name == *joint && own.nq == numbers.len());
            if let Some(own) = found {
                q[own.q()].copy_from_slice(numbers);
            }
        }
        for (joint, numbers) in &pose.velocities {
            let found = self.joints.iter().find(|own| own.name == *joint && own.nv == numbers.len());
            if let Some(own) = found {
                v[own.v()].copy_from_slice(numbers);
            }
        }
        Some((q, v))
    }
}
