//! Motors with gears, and elastic joints.

use robot_dynamics_number::{InvalidInput, check_positive};

use super::note::EditNote;
use crate::validation::check_motor;
use crate::{
    ActuatorDescription, ElectricMotor, JointDescription, JointKind, LinkDescription, ModelError,
    PassiveForces, Pose, RobotDescription, TendonDescription, Transmission,
};

/// An electric motor that drives a joint through a gear.
///
/// ```
/// use robot_dynamics::description::{ElectricMotor, MotorDrive};
/// let motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0); // N m, rad/s, V
/// let drive = MotorDrive::new(motor, 100.0, 2e-5); // gear, kg m² of the rotor
/// assert_eq!(drive.reflected_inertia(), 100.0 * 100.0 * 2e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MotorDrive {
    /// The motor, at its shaft.
    pub motor: ElectricMotor,
    /// n, the turns of the shaft for one of the joint \[1, or rad/m for a prismatic joint\].
    pub gear: f64,
    /// The moment of inertia of the rotor about its axis \[kg·m²\].
    pub rotor_inertia: f64,
}

impl MotorDrive {
    /// A motor with a gear and the inertia of its rotor.
    pub const fn new(motor: ElectricMotor, gear: f64, rotor_inertia: f64) -> Self {
        Self { motor, gear, rotor_inertia }
    }

    /// n² J, the inertia of the rotor at the joint \[kg·m², or kg for a prismatic joint\].
    pub fn reflected_inertia(&self) -> f64 {
        self.gear * self.gear * self.rotor_inertia
    }
}

/// The elasticity between a motor and its joint, for example of a harmonic drive, at the joint's side.
///
/// ```
/// let soft = robot_dynamics::description::JointElasticity::new(1e4, 5.0);
/// assert_eq!(soft.backlash, 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct JointElasticity {
    /// The stiffness \[N·m/rad or N/m\].
    pub stiffness: f64,
    /// The damping \[N·m·s/rad or N·s/m\].
    pub damping: f64,
    /// The backlash: the width of the dead band of the spring \[rad or m\].
    pub backlash: f64,
}

impl JointElasticity {
    /// A spring with a damper, without backlash.
    pub const fn new(stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, backlash: 0.0 }
    }
}

impl RobotDescription {
    /// Adds the inertia of a rotor to a joint, and the actuator `JOINT_motor`, whose control is the torque
    /// that is requested at the motor's shaft \[N·m\].
    ///
    /// ```
    /// use robot_dynamics::description::{ElectricMotor, MotorDrive, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0);
    /// motor.current_limit = 6.0;
    /// robot.add_motor("hinge", &MotorDrive::new(motor, 100.0, 2e-5))?;
    /// assert_eq!(robot.joints[0].passive.armature, 0.2);
    /// assert_eq!(robot.actuators[0].name, "hinge_motor");
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if the joint is unknown, follows another one, or does not have one degree of freedom,
    /// the name is taken, or a number is invalid. The robot is then unchanged.
    pub fn add_motor(&mut self, joint: &str, drive: &MotorDrive) -> Result<(), ModelError> {
        let index = self.single_joint(joint)?;
        check_positive("the gear", drive.gear, "")?;
        if !(drive.rotor_inertia >= 0.0 && drive.rotor_inertia.is_finite()) {
            let (inertia, unit) = (drive.rotor_inertia, "kg·m²");
            return Err(
                InvalidInput::out_of_range("the rotor's inertia", inertia, unit, "zero or positive").into()
            );
        }
        let name = format!("{joint}_motor");
        if self.actuators.iter().any(|own| own.name == name) {
            return Err(ModelError::DuplicateName { sort: "actuator", name });
        }
        let mut actuator = ActuatorDescription::new(name, Transmission::joint(joint, drive.gear));
        actuator.motor = Some(drive.motor);
        check_motor(&format!("actuator `{}`", actuator.name), &drive.motor)?;
        self.joints[index].passive.armature += drive.reflected_inertia();
        self.actuators.push(actuator);
        Ok(())
    }

    /// Makes a joint elastic. It keeps its name for the motor's side, with its armature, limits, friction and
    /// actuators. A new joint `JOINT_elastic` without a motor turns the link relative to it, with a massless
    /// link `JOINT_output` in between. The angle of the link is the sum of both. With a backlash, the tendon
    /// `JOINT_backlash` is the spring.
    ///
    /// > B θ̈ + k (θ − q) + d (θ̇ − q̇) = τ_m,  M q̈ + C q̇ + g = k (θ − q) + d (θ̇ − q̇)
    ///
    /// B is the armature, θ the motor's angle at the joint's side, q that of the link. The gyroscopic forces
    /// of the rotor are left out. **(Spong, *Modeling and control of elastic joint robots*, J. Dynamic
    /// Systems, Measurement and Control 109, 1987)**
    ///
    /// ```
    /// use robot_dynamics::description::{JointElasticity, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive.armature = 0.2;
    /// robot.add_joint_elasticity("hinge", &JointElasticity::new(1e4, 5.0))?;
    /// let model = Model::new(robot)?;
    /// assert_eq!(model.coordinate_names(), ["hinge", "hinge_elastic"]);
    /// assert_eq!(model.actuated_dofs(), [true, false]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if the joint is unknown, follows another one, does not have one degree of freedom, or
    /// has no armature. The same if a name is taken, or a number is invalid. The robot is then unchanged.
    pub fn add_joint_elasticity(
        &mut self,
        joint: &str,
        elasticity: &JointElasticity,
    ) -> Result<Vec<EditNote>, ModelError> {
        let index = self.single_joint(joint)?;
        let JointElasticity { stiffness, damping, backlash } = *elasticity;
        check_positive("the stiffness", stiffness, "")?;
        for (name, value) in [("the damping", damping), ("the backlash", backlash)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(InvalidInput::out_of_range(name, value, "", "zero or positive").into());
            }
        }
        let own = &self.joints[index];
        if own.passive.armature <= 0.0 {
            let requirement = "needs an armature, the inertia of its rotor; add the motor first";
            return Err(InvalidInput::unmet(format!("joint `{joint}`"), requirement).into());
        }
        let [output, elastic, band] = ["output", "elastic", "backlash"].map(|part| format!("{joint}_{part}"));
        self.check_place_name("link", &output)?;
        if self.joints.iter().any(|own| own.name == elastic) {
            return Err(ModelError::DuplicateName { sort: "joint", name: elastic });
        }
        if self.tendons.iter().any(|own| own.name == band) {
            return Err(ModelError::DuplicateName { sort: "tendon", name: band });
        }
        let kind = match &own.kind {
            JointKind::Continuous { axis } => JointKind::Revolute { axis: *axis },
            kind => *kind,
        };
        let mut second = JointDescription::new(&elastic, kind, &output, &own.child, Pose::IDENTITY);
        let spring = |rest: f64| PassiveForces::default().with_spring(stiffness, rest).with_damping(damping);
        if backlash == 0.0 {
            second.passive = spring(0.0);
        } else {
            let mut tendon = TendonDescription::new(&band, [(elastic.clone(), 1.0)]);
            tendon.passive = spring(-0.5 * backlash);
            tendon.dead_band = backlash;
            self.tendons.push(tendon);
        }
        let driven = self.actuated_joints.take().unwrap_or_else(|| self.driven_by_default());
        self.actuated_joints = Some(driven);
        self.joints[index].child.clone_from(&output);
        self.links.push(LinkDescription::new(output, None));
        self.joints.insert(index + 1, second);
        let followers =
            self.joints.iter().filter(|own| own.mimic.as_ref().is_some_and(|mimic| mimic.joint == joint));
        let note = |own: &JointDescription| {
            EditNote::new(format!("joint `{}`", own.name), format!("follows the motor of joint `{joint}`"))
        };
        Ok(followers.map(note).collect())
    }

    /// The index of a joint with one degree of freedom of its own.
    fn single_joint(&self, name: &str) -> Result<usize, ModelError> {
        let index = self.joint_index(name)?;
        let joint = &self.joints[index];
        if let Some(mimic) = &joint.mimic {
            return Err(ModelError::Follows { joint: name.into(), leader: mimic.joint.clone() });
        }
        match joint.kind {
            JointKind::Revolute { .. } | JointKind::Continuous { .. } | JointKind::Prismatic { .. } => {
                Ok(index)
            }
            _ => {
                let requirement = "must be revolute, continuous or prismatic";
                Err(InvalidInput::unmet(format!("joint `{name}`"), requirement).into())
            }
        }
    }

    /// The joints that are driven if the robot does not state it: all that move, but floating ones.
    fn driven_by_default(&self) -> Vec<String> {
        let is_driven =
            |joint: &&JointDescription| joint.kind.nv() > 0 && !matches!(joint.kind, JointKind::Floating);
        self.joints.iter().filter(is_driven).map(|joint| joint.name.clone()).collect()
    }
}
