//! Sensors, as a robot's file or a user describes them.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Shape;

/// A sensor: its kind and the object that it is on. `SensorSet` evaluates it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct SensorDescription {
    /// Its name, unique among sensors.
    pub name: String,
    /// The quantity that it measures.
    pub kind: SensorKind,
    /// The object that it is on.
    pub object: SensorObject,
    /// The frame whose axes and motion the values are relative to; `None` for the world. Sensors of a frame's
    /// pose and velocity have one; that of [`SensorKind::InsideSite`] is the frame of its zone.
    #[cfg_attr(feature = "serde", serde(default))]
    pub reference: Option<SensorObject>,
    /// The region of a touch sensor, relative to its frame, or the region of [`SensorKind::InsideSite`].
    /// `None` means the whole link.
    #[cfg_attr(feature = "serde", serde(default))]
    pub zone: Option<Shape>,
    /// The magnetic field in the world that a magnetometer measures \[any unit\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub field: [f64; 3],
    /// The bound of values, on both sides, or only above for values that are never negative; 0 means no
    /// bound. Quaternions and axes have no bound.
    #[cfg_attr(feature = "serde", serde(default))]
    pub cutoff: f64,
    /// Standard deviation of the noise that the file gives. It is not added to values.
    #[cfg_attr(feature = "serde", serde(default))]
    pub noise: f64,
}

/// The object that a sensor is on, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum SensorObject {
    /// The whole robot: time and energies.
    Robot,
    /// A frame or link, or a joint, tendon or actuator, depending on the kind.
    Named(String),
    /// A frame at a link's centre of mass, whose axes are the link's.
    CenterOfMass(String),
    /// The frame of a shape.
    Shape(String),
}

impl<T: Into<String>> From<T> for SensorObject {
    fn from(name: T) -> Self {
        Self::Named(name.into())
    }
}

/// The sort of a sensor's object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum ObjectSort {
    Robot,
    Frame,
    Link,
    Joint,
    Ball,
    Tendon,
    Actuator,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident($name:literal, $size:literal, $sort:ident))*) => {
        /// The quantity that a sensor measures, with the number of values and their units in parentheses.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
        #[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
        #[non_exhaustive]
        pub enum SensorKind {
            $($(#[$doc])* $variant,)*
        }

        impl SensorKind {
            /// Every kind.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its name in MJCF, for example `framelinvel`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The number of values.
            pub fn size(self) -> usize {
                match self {
                    $(Self::$variant => $size,)*
                }
            }

            #[doc(hidden)]
            pub fn sort(self) -> ObjectSort {
                match self {
                    $(Self::$variant => ObjectSort::$sort,)*
                }
            }
        }
    };
}

kinds! {
    /// Proper acceleration of a frame's origin, p̈ − g, along the frame's axes (3, m/s²). At rest it is +9.81
    /// upwards.
    Accelerometer("accelerometer", 3, Frame)
    /// Velocity of a frame's origin along the frame's axes (3, m/s).
    Velocimeter("velocimeter", 3, Frame)
    /// Angular velocity of a frame along its axes (3, rad/s).
    Gyro("gyro", 3, Frame)
    /// The magnetic field along a frame's axes (3).
    Magnetometer("magnetometer", 3, Frame)
    /// The force that the frame's link receives from its parent, along the frame's axes (3, N); see
    /// `joint_reactions`.
    Force("force", 3, Frame)
    /// The moment that the frame's link receives from its parent, about the frame's origin, along its axes
    /// (3, N·m).
    Torque("torque", 3, Frame)
    /// Sum of the normal forces of contacts of the frame's link in a zone about the frame (1, N).
    Touch("touch", 1, Frame)
    /// Position of a joint of one DoF (1, rad or m).
    JointPosition("jointpos", 1, Joint)
    /// Velocity of a joint of one DoF (1, rad/s or m/s).
    JointVelocity("jointvel", 1, Joint)
    /// Generalized force of all actuators on a joint of one DoF (1, N·m or N).
    JointActuatorForce("jointactuatorfrc", 1, Joint)
    /// Distance of a joint's position from the nearest limit, less the margin, if it is negative; else
    /// 0 (1, rad or m).
    JointLimitPosition("jointlimitpos", 1, Joint)
    /// Rate of that distance; 0 if the limit is not reached (1, rad/s or m/s).
    JointLimitVelocity("jointlimitvel", 1, Joint)
    /// Force of a joint's limit, positive away from it (1, N·m or N).
    JointLimitForce("jointlimitfrc", 1, Joint)
    /// Length of a tendon (1, m or rad).
    TendonPosition("tendonpos", 1, Tendon)
    /// Rate of a tendon's length (1, m/s or rad/s).
    TendonVelocity("tendonvel", 1, Tendon)
    /// Sum of the forces of the actuators on a tendon, before their gears (1, N).
    TendonActuatorForce("tendonactuatorfrc", 1, Tendon)
    /// As [`SensorKind::JointLimitPosition`], for a tendon (1).
    TendonLimitPosition("tendonlimitpos", 1, Tendon)
    /// As [`SensorKind::JointLimitVelocity`], for a tendon (1).
    TendonLimitVelocity("tendonlimitvel", 1, Tendon)
    /// As [`SensorKind::JointLimitForce`], for a tendon (1).
    TendonLimitForce("tendonlimitfrc", 1, Tendon)
    /// Length of an actuator's transmission (1).
    ActuatorPosition("actuatorpos", 1, Actuator)
    /// Rate of that length (1).
    ActuatorVelocity("actuatorvel", 1, Actuator)
    /// Force of an actuator, before its gear (1, N·m or N).
    ActuatorForce("actuatorfrc", 1, Actuator)
    /// Orientation of a spherical joint, x y z w (4).
    BallQuaternion("ballquat", 4, Ball)
    /// Angular velocity of a spherical joint along the child's axes (3, rad/s).
    BallAngularVelocity("ballangvel", 3, Ball)
    /// Position of a frame's origin (3, m).
    FramePosition("framepos", 3, Frame)
    /// Orientation of a frame, x y z w, w not negative (4).
    FrameQuaternion("framequat", 4, Frame)
    /// The frame's x axis (3).
    FrameXAxis("framexaxis", 3, Frame)
    /// The frame's y axis (3).
    FrameYAxis("frameyaxis", 3, Frame)
    /// The frame's z axis (3).
    FrameZAxis("framezaxis", 3, Frame)
    /// Velocity of a frame's origin along the world's axes, or relative to a reference frame (3, m/s).
    FrameLinearVelocity("framelinvel", 3, Frame)
    /// Angular velocity of a frame along the world's axes, or relative to a reference frame (3, rad/s).
    FrameAngularVelocity("frameangvel", 3, Frame)
    /// Proper acceleration of a frame's origin, p̈ − g, along the world's axes (3, m/s²).
    FrameLinearAcceleration("framelinacc", 3, Frame)
    /// Angular acceleration of a frame along the world's axes (3, rad/s²).
    FrameAngularAcceleration("frameangacc", 3, Frame)
    /// Centre of mass of a link's subtree, in the world (3, m).
    SubtreeCenterOfMass("subtreecom", 3, Link)
    /// Velocity of that point (3, m/s).
    SubtreeLinearVelocity("subtreelinvel", 3, Link)
    /// Angular momentum of a link's subtree about its centre of mass, along the world's axes (3, kg·m²/s).
    SubtreeAngularMomentum("subtreeangmom", 3, Link)
    /// 1 if the object's origin is in the zone about the reference frame, else 0 (1).
    InsideSite("insidesite", 1, Frame)
    /// Potential energy of gravity and springs (1, J).
    PotentialEnergy("e_potential", 1, Robot)
    /// Kinetic energy (1, J).
    KineticEnergy("e_kinetic", 1, Robot)
    /// Time (1, s).
    Clock("clock", 1, Robot)
}

impl SensorKind {
    /// The kind of this name in MJCF.
    ///
    /// ```
    /// use robot_dynamics::description::SensorKind;
    /// assert_eq!(SensorKind::named("gyro"), Some(SensorKind::Gyro));
    /// assert_eq!(SensorKind::named("camera"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// Whether it measures a generalized force of a joint, which a mimic joint does not have itself.
    pub fn needs_own_force(self) -> bool {
        matches!(self, Self::JointActuatorForce | Self::JointLimitForce)
    }

    /// Whether its values can be relative to a reference frame.
    pub fn takes_reference(self) -> bool {
        matches!(
            self,
            Self::FramePosition
                | Self::FrameQuaternion
                | Self::FrameXAxis
                | Self::FrameYAxis
                | Self::FrameZAxis
                | Self::FrameLinearVelocity
                | Self::FrameAngularVelocity
                | Self::InsideSite
        )
    }
}

impl SensorDescription {
    /// Whether it measures the joint's own position, velocity or force.
    pub fn is_of_joint(&self, joint: &str) -> bool {
        let is_joint = matches!(self.kind.sort(), ObjectSort::Joint | ObjectSort::Ball);
        is_joint && matches!(&self.object, SensorObject::Named(name) if name == joint)
    }

    /// A sensor on an object by name: a frame or link, or a joint, tendon or actuator, depending on the kind.
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind, SensorObject, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.sensors.push(SensorDescription::new("imu", SensorKind::Accelerometer, "tip"));
    /// robot.sensors.push(SensorDescription::new("encoder", SensorKind::JointPosition, "hinge"));
    /// robot.sensors.push(SensorDescription::new("time", SensorKind::Clock, SensorObject::Robot));
    /// assert_eq!(Model::new(robot)?.description().sensors.len(), 3);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn new(name: impl Into<String>, kind: SensorKind, object: impl Into<SensorObject>) -> Self {
        Self {
            name: name.into(),
            kind,
            object: object.into(),
            reference: None,
            zone: None,
            field: [0.0; 3],
            cutoff: 0.0,
            noise: 0.0,
        }
    }

    /// With values relative to this frame or link.
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind};
    /// let reach = SensorDescription::new("reach", SensorKind::FramePosition, "tip").relative_to("ceiling");
    /// assert_eq!(reach.reference, Some("ceiling".into()));
    /// ```
    pub fn relative_to(self, reference: impl Into<SensorObject>) -> Self {
        Self { reference: Some(reference.into()), ..self }
    }

    /// With a zone relative to its frame; see [`SensorDescription::zone`].
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind, Shape};
    /// let ball = Shape::Sphere { radius: 0.02 };
    /// let pad = SensorDescription::new("pad", SensorKind::Touch, "tip").within(ball);
    /// assert!(pad.zone.is_some());
    /// ```
    pub fn within(self, zone: Shape) -> Self {
        Self { zone: Some(zone), ..self }
    }

    /// With this bound of values.
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind};
    /// let imu = SensorDescription::new("imu", SensorKind::Accelerometer, "tip").with_cutoff(160.0);
    /// assert_eq!(imu.cutoff, 160.0);
    /// ```
    pub fn with_cutoff(self, cutoff: f64) -> Self {
        Self { cutoff, ..self }
    }
}
