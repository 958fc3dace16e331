//! The actuated degrees of freedom.

use crate::{Base, ModelError, RobotDescription};

impl RobotDescription {
    /// Sets the joints that motors drive. Controllers give torques only to their degrees of freedom
    /// (`Model::actuated_dofs`).
    ///
    /// A floating base is actuated if [`floating_base_name`](Self::floating_base_name) is in the list, as for
    /// a satellite with thrusters.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, RobotDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.base = Base::Floating;
    /// assert_eq!(Model::new(robot.clone())?.actuated_dofs(), [false, false, false, false, false, false, true]);
    /// robot.set_actuated_joints(["floating_base"])?;
    /// assert_eq!(Model::new(robot)?.actuated_dofs(), [true, true, true, true, true, true, false]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if there is no joint of a given name. The robot is then unchanged.
    pub fn set_actuated_joints<N: Into<String>>(
        &mut self,
        joints: impl IntoIterator<Item = N>,
    ) -> Result<(), ModelError> {
        let joints: Vec<String> = joints.into_iter().map(Into::into).collect();
        if let Some(name) = joints.iter().find(|name| !self.has_joint(name)) {
            return Err(self.no_joint(name).into());
        }
        self.actuated_joints = Some(joints);
        Ok(())
    }

    /// Whether there is a joint of this name, including the floating base.
    fn has_joint(&self, name: &str) -> bool {
        self.joints.iter().any(|joint| joint.name == name)
            || self.base == Base::Floating && self.floating_base_name() == name
    }
}

/// Rejects unknown joint names.
pub(crate) fn check_actuated(description: &RobotDescription) -> Result<(), ModelError> {
    let unknown = description.actuated_joints.iter().flatten().find(|name| !description.has_joint(name));
    unknown.map_or(Ok(()), |name| {
        let user = "the list of actuated joints".to_owned();
        Err(ModelError::UnknownName { user, sort: "joint", name: name.clone() })
    })
}
