//! Sensors: of a robot's motion, of its actuators, and of the forces in its joints and contacts.
//!
//! A [`SensorSet`] resolves once, by name, where each
//! [`SensorDescription`](robot_dynamics_description::SensorDescription) is attached. Its
//! [`evaluate`](SensorSet::evaluate) takes q, v, a and the active forces, computes the motion of all bodies
//! once, and does not allocate. Noise in the description is not added.

mod evaluate;
mod reading;
mod subtree;
mod zone;

use core::ops::Range;

use reading::{Reading, Sensor};
use robot_dynamics_core::algorithms::joint_reactions::NUMBERS;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::{FrameId, Model, Workspace};
use robot_dynamics_description::{ModelError, SensorKind};

use crate::{Actuation, ActuationWorkspace};

/// The sensors of one robot, ready to be evaluated.
///
/// ```
/// use robot_dynamics::description::{SensorDescription, SensorKind, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{SensorInputs, SensorSet};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.sensors.push(SensorDescription::new("imu", SensorKind::Accelerometer, "tip"));
/// robot.sensors.push(SensorDescription::new("load", SensorKind::Force, "rod"));
/// let model = Model::new(robot)?;
/// let sensors = SensorSet::new(&model)?;
/// let (mut memory, mut values) = (sensors.memory(&model), vec![0.0; sensors.value_count()]);
/// let inputs = SensorInputs::new(&[0.0], &[3.0], &[0.0]); // level, turning at 3 rad/s
/// sensors.evaluate(&model, &mut memory, &inputs, &mut values);
/// let imu = &values[sensors.range(0)];
/// assert!((imu[0] + 3.0_f64.powi(2) * 0.5).abs() < 1e-14); // towards the hinge
/// assert!((imu[2] - 9.81).abs() < 1e-14); // gravity shows as an upward acceleration
/// assert!((values[5] - 2.0 * 9.81).abs() < 1e-13); // the joint carries the weight
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SensorSet {
    robot: Identity,
    sensors: Vec<Sensor>,
    actuation: Actuation,
    /// The potential energy of links fixed to the world \[J\].
    fixed_energy: f64,
    needs: SensorRequirements,
    values: usize,
}

/// The quantities that only some sensors need.
#[derive(Clone, Copy, Debug, Default)]
struct SensorRequirements {
    energy: bool,
    reactions: bool,
    actuator_torques: bool,
}

/// The memory of [`SensorSet::evaluate`].
#[derive(Clone, Debug)]
pub struct SensorMemory {
    dynamics: Workspace,
    actuation: ActuationWorkspace,
    /// Six numbers a link: the external wrench, in world axes about its origin; the wrench that its joint
    /// transmits.
    external: Vec<f64>,
    reactions: Vec<f64>,
    actuator_torques: Vec<f64>,
}

/// A force and a moment on a link, in world axes, at a point of the world: a contact, a push, a thruster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointForce {
    /// The link on which it acts, or a frame of it.
    pub link: FrameId,
    /// The point of action, in the world \[m\].
    pub point: [f64; 3],
    /// The force on the link \[N\].
    pub force: [f64; 3],
    /// The moment on the link, in addition to that of the force \[N·m\].
    pub moment: [f64; 3],
    /// The contact's unit normal, towards the link; zero if this is not a contact. Touch sensors measure the
    /// force along it.
    pub normal: [f64; 3],
}

impl PointForce {
    /// A push: no contact, no moment.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::PointForce;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let push = PointForce::new(model.frame_named("rod")?, [0.5, 0.0, 0.0], [0.0, 0.0, 3.0]);
    /// assert_eq!((push.moment, push.normal), ([0.0; 3], [0.0; 3]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(link: FrameId, point: [f64; 3], force: [f64; 3]) -> Self {
        Self { link, point, force, moment: [0.0; 3], normal: [0.0; 3] }
    }
}

/// The inputs of an evaluation of sensors.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SensorInputs<'a> {
    /// \[s\].
    pub time: f64,
    /// nq numbers.
    pub q: &'a [f64],
    /// nv numbers.
    pub v: &'a [f64],
    /// The acceleration caused by all forces together, nv numbers.
    pub a: &'a [f64],
    /// Each actuator's force before its gear \[N·m or N\], in the description's order; empty if there is
    /// none.
    pub actuator_forces: &'a [f64],
    /// The generalized forces of position limits \[N·m or N\], nv numbers; empty if no limit acts.
    pub joint_limit_forces: &'a [f64],
    /// The force of each tendon's limits along its length \[N\]; empty if no limit acts.
    pub tendon_limit_forces: &'a [f64],
    /// All external forces on links: contacts, pushes, thrusters, forces of loops.
    pub wrenches: &'a [PointForce],
}

impl<'a> SensorInputs<'a> {
    /// A motion at time 0 without actuators, active limits and external forces.
    ///
    /// ```
    /// let inputs = robot_dynamics::simulation::SensorInputs::new(&[0.1], &[0.2], &[0.3]);
    /// assert!(inputs.time == 0.0 && inputs.wrenches.is_empty());
    /// ```
    pub fn new(q: &'a [f64], v: &'a [f64], a: &'a [f64]) -> Self {
        Self {
            time: 0.0,
            q,
            v,
            a,
            actuator_forces: &[],
            joint_limit_forces: &[],
            tendon_limit_forces: &[],
            wrenches: &[],
        }
    }
}

impl SensorSet {
    /// Resolves the sensors of the model's description.
    ///
    /// # Errors
    /// As [`Actuation::new`]. A model from a file does not cause errors.
    pub fn new(model: &Model) -> Result<Self, ModelError> {
        let (mut sensors, mut values) = (Vec::new(), 0);
        let mut needs = SensorRequirements::default();
        for description in &model.description.sensors {
            let range = values..values + description.kind.size();
            values = range.end;
            match description.kind {
                SensorKind::Force | SensorKind::Torque => needs.reactions = true,
                SensorKind::JointActuatorForce => needs.actuator_torques = true,
                SensorKind::PotentialEnergy | SensorKind::KineticEnergy => needs.energy = true,
                _ => {}
            }
            sensors.push(Sensor {
                name: description.name.clone(),
                kind: description.kind,
                reading: Reading::new(model, description),
                cutoff: if description.cutoff > 0.0 { description.cutoff } else { f64::INFINITY },
                range,
            });
        }
        Ok(Self {
            robot: model.identity.clone(),
            sensors,
            actuation: Actuation::new(model)?,
            fixed_energy: reading::energy_of_fixed_links(model),
            needs,
            values,
        })
    }

    /// The number of sensors.
    pub fn len(&self) -> usize {
        self.sensors.len()
    }

    /// Whether there are no sensors.
    pub fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// The number of values of all sensors together.
    pub fn value_count(&self) -> usize {
        self.values
    }

    /// Their names, in the order of their values.
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SensorSet;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.sensors.push(SensorDescription::new("spin", SensorKind::Gyro, "tip"));
    /// robot.sensors.push(SensorDescription::new("encoder", SensorKind::JointPosition, "hinge"));
    /// let sensors = SensorSet::new(&Model::new(robot)?)?;
    /// assert!(sensors.names().eq(["spin", "encoder"]));
    /// assert_eq!((sensors.range(0), sensors.range(1)), (0..3, 3..4));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sensors.iter().map(|sensor| sensor.name.as_str())
    }

    /// Their kinds, in the same order.
    pub fn kinds(&self) -> impl Iterator<Item = SensorKind> + '_ {
        self.sensors.iter().map(|sensor| sensor.kind)
    }

    /// The range of a sensor's values.
    ///
    /// # Panics
    /// If the index is out of range.
    #[track_caller]
    pub fn range(&self, sensor: usize) -> Range<usize> {
        self.sensors[sensor].range.clone()
    }

    /// Returns memory for the set's calls, which then do not allocate.
    ///
    /// # Panics
    /// If the model belongs to another robot.
    #[track_caller]
    pub fn memory(&self, model: &Model) -> SensorMemory {
        model.check_identity(&self.robot, "the sensor set");
        let links = model.segments.list.len();
        SensorMemory {
            dynamics: Workspace::new(model),
            actuation: self.actuation.workspace(),
            external: vec![0.0; NUMBERS * links],
            reactions: vec![0.0; NUMBERS * links],
            actuator_torques: vec![0.0; model.nv],
        }
    }
}
