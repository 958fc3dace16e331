//! Conversion of joint equalities to mimic joints.

use crate::{Equality, JointKind, Mimic, RobotDescription};

impl RobotDescription {
    /// Replaces active equalities that give a joint's position as a linear function of another's by mimic
    /// joints ([`Mimic`]).
    ///
    /// The equalities are removed: their forces are not computed, and M is that of the independent joints.
    /// Equalities that would close a cycle, or that name a mimic joint, remain. Sensors of actuator forces
    /// and limits on a mimic joint are removed, because these forces act on its leader. Returns the mimic
    /// joints' names.
    ///
    /// ```
    /// use robot_dynamics::description::{Equality, EqualityDescription, JointDescription};
    /// use robot_dynamics::description::{JointKind, LinkDescription, Pose, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    /// robot.links.push(LinkDescription::new("second", robot.links[1].mass_properties));
    /// robot.joints.push(JointDescription::new("knee", hinge, "rod", "second", Pose::IDENTITY));
    /// let gear = Equality::Joints {
    ///     joint: ("knee".into(), 0.0),
    ///     leader: Some(("hinge".into(), 0.0)),
    ///     polynomial: [0.1, -2.0, 0.0, 0.0, 0.0],
    /// };
    /// robot.equalities.push(EqualityDescription::new("gear", gear));
    /// assert_eq!(Model::new(robot.clone())?.nv(), 2);
    /// assert_eq!(robot.couplings_to_followers(), ["knee"]);
    /// assert_eq!(Model::new(robot)?.nv(), 1);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn couplings_to_followers(&mut self) -> Vec<String> {
        let mut mimic_joints = Vec::new();
        let equalities = core::mem::take(&mut self.equalities);
        for equality in equalities {
            match linear(&equality.kind).filter(|_| equality.active) {
                Some((joint, mimic)) if self.follow(&joint, &mimic) => {
                    self.sensors
                        .retain(|sensor| !(sensor.is_of_joint(&joint) && sensor.kind.needs_own_force()));
                    mimic_joints.push(joint);
                }
                _ => self.equalities.push(equality),
            }
        }
        mimic_joints
    }

    /// Makes the joint a mimic joint; returns whether it could. It cannot if it is one already, if one of the
    /// two joints is fixed or missing, or if the chain of leaders would return to it.
    #[doc(hidden)]
    pub fn follow(&mut self, joint: &str, mimic: &Mimic) -> bool {
        let find = |robot: &Self, name: &str| robot.joints.iter().position(|joint| joint.name == name);
        let (Some(index), Some(leader)) = (find(self, joint), find(self, &mimic.joint)) else { return false };
        let is_moved = |at: usize| self.joints[at].kind != JointKind::Fixed;
        if self.joints[index].mimic.is_some() || !is_moved(index) || !is_moved(leader) {
            return false;
        }
        // The chain of leaders must not return to the joint.
        let mut at = Some(leader);
        while let Some(leader) = at {
            if leader == index {
                return false;
            }
            at = self.joints[leader].mimic.as_ref().and_then(|mimic| find(self, &mimic.joint));
        }
        self.joints[index].mimic = Some(mimic.clone());
        true
    }
}

/// y = y⁰ + c₀ + c₁ (x − x⁰), as a mimic joint.
fn linear(kind: &Equality) -> Option<(String, Mimic)> {
    let Equality::Joints { joint: (name, y0), leader: Some((leader, x0)), polynomial: [c0, c1, higher @ ..] } =
        kind
    else {
        return None;
    };
    let is_linear = higher.iter().all(|c| *c == 0.0);
    is_linear.then(|| (name.clone(), Mimic::new(leader, *c1, y0 + c0 - c1 * x0)))
}
