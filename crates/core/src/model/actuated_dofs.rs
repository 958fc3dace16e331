//! The actuated degrees of freedom.

use robot_dynamics_description::JointKind;

use crate::Model;

impl Model {
    /// Whether each degree of freedom is driven by a motor, nv entries.
    ///
    /// The default is all joints except floating ones.
    /// [`RobotDescription::set_actuated_joints`](robot_dynamics_description::RobotDescription::set_actuated_joints)
    /// overrides it. An actuated mimic joint drives its leader's coordinate.
    ///
    /// `GravityCompensatedPd`, `ComputedTorque` and `TaskControl` give no torque to the others. The equation
    /// of motion accepts every τ, and the `actuators` of a file act as the file specifies.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.actuated_dofs(), [true]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn actuated_dofs(&self) -> &[bool] {
        &self.actuated
    }

    /// The entries of [`actuated_dofs`](Self::actuated_dofs); requires the compiled joints.
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
