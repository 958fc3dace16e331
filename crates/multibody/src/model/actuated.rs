//! The degrees of freedom that motors drive.

use crate::joint::kind::JointKind;
use crate::model::surgery::SurgeryError;
use crate::{Base, Model, ModelError, RobotDescription};

impl RobotDescription {
    /// States which joints motors drive: these and no others. Controllers give torques to their degrees of freedom alone
    /// ([`Model::actuated_dofs`]).
    ///
    /// A floating base is actuated where it is named, by [`floating_base_name`](Self::floating_base_name): a satellite with thrusters.
    ///
    /// ```
    /// use multibody::{Base, Model, RobotDescription, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.base = Base::Floating;
    /// assert_eq!(Model::new(robot.clone())?.actuated_dofs(), [false, false, false, false, false, false, true]);
    /// robot.set_actuated_joints(["floating_base"])?;
    /// assert_eq!(Model::new(robot)?.actuated_dofs(), [true, true, true, true, true, true, false]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SurgeryError::NoSuch`] if there is no joint of a name; nothing has changed then.
    pub fn set_actuated_joints<N: Into<String>>(
        &mut self,
        joints: impl IntoIterator<Item = N>,
    ) -> Result<(), SurgeryError> {
        let joints: Vec<String> = joints.into_iter().map(Into::into).collect();
        if let Some(name) = joints.iter().find(|name| !self.has_joint(name)) {
            return Err(SurgeryError::NoSuch { sort: "joint", name: name.clone() });
        }
        self.actuated_joints = Some(joints);
        Ok(())
    }

    /// Whether there is a joint of this name, the floating base included.
    fn has_joint(&self, name: &str) -> bool {
        self.joints.iter().any(|joint| joint.name == name)
            || self.base == Base::Floating && self.floating_base_name() == name
    }
}

/// Refuses names of joints that the robot does not have.
pub(crate) fn check_actuated(description: &RobotDescription) -> Result<(), ModelError> {
    let unknown = description.actuated_joints.iter().flatten().find(|name| !description.has_joint(name));
    unknown.map_or(Ok(()), |name| {
        let user = "the list of actuated joints".to_owned();
        Err(ModelError::UnknownName { user, sort: "joint", name: name.clone() })
    })
}

impl Model {
    /// The degrees of freedom that motors drive, nv entries: those of all joints but floating ones, unless the description says it by
    /// [`RobotDescription::set_actuated_joints`]. A mimic joint that is driven drives the coordinate that it follows.
    ///
    /// [`GravityCompensatedPd`](crate::GravityCompensatedPd), [`ComputedTorque`](crate::ComputedTorque) and
    /// [`TaskControl`](crate::TaskControl) give no torque to the others. In the equation of motion every τ remains possible, and the
    /// [`actuators`](RobotDescription::actuators) of a file act where the file says.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.actuated_dofs(), [true]);
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn actuated_dofs(&self) -> &[bool] {
        &self.actuated
    }

    /// The entries of [`actuated_dofs`](Self::actuated_dofs), once the joints are known.
    pub(crate) fn find_actuated(&mut self) {
        let mut actuated = vec![false; self.nv];
        for dof in &self.dofs {
            let joint = &self.joints[dof.joint];
            let is_driven = match &self.description.actuated_joints {
                Some(names) => names.contains(&joint.name),
                None => joint.kind != JointKind::Floating,
            };
            actuated[dof.coordinate] |= is_driven;
        }
        self.actuated = actuated;
    }
}
