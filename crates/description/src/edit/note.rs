//! The consequences of an edit.

use core::fmt;

/// A consequence of an edit for another part of the robot: a part that was removed or changed because it
/// refers to a removed or changed part.
///
/// ```
/// use robot_dynamics::description::{SensorDescription, SensorKind, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.sensors.push(SensorDescription::new("encoder", SensorKind::JointPosition, "hinge"));
/// let notes = robot.remove_joint("hinge")?;
/// assert_eq!(notes[0].to_string(), "sensor `encoder`: removed with joint `hinge`");
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct EditNote {
    /// The part, for example ``actuator `elbow_motor` ``.
    pub place: String,
    /// The change.
    pub message: String,
}

impl EditNote {
    pub(crate) fn new(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self { place: place.into(), message: message.into() }
    }
}

impl fmt::Display for EditNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}
