//! Locking of joints that move no inertia.

use robot_dynamics_description::{Base, ModelError, RobotDescription};

use crate::Model;

/// Locks the joints that move no inertia in any pose ([`Model::massless_joints`]), each at its
/// [`resting_position`](RobotDescription::resting_position). Repeats until every joint moves
/// inertia, because locking a joint can leave its parent joint without inertia to move.
///
/// A floating base that moves no inertia becomes fixed. Returns the names of the locked joints.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::lock_massless;
/// let mut robot = pendulum(2.0, 0.5);
/// assert!(lock_massless(&mut robot)?.is_empty());
/// robot.links[1].mass_properties = None; // the hinge moves no mass
/// assert_eq!(lock_massless(&mut robot)?, ["hinge"]);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Errors
/// [`ModelError`]: the description is invalid.
pub fn lock_massless(robot: &mut RobotDescription) -> Result<Vec<String>, ModelError> {
    let mut locked = Vec::new();
    loop {
        let model = Model::new(robot.clone())?;
        let massless: Vec<String> = model.massless_joints().map(Into::into).collect();
        if massless.is_empty() {
            return Ok(locked);
        }
        for name in massless {
            // The base's joint is the first of the model, but absent from the description.
            if robot.base == Base::Floating && name == model.joints()[0].name {
                robot.base = Base::Fixed;
            } else {
                let q = robot.resting_position(&name)?;
                robot.lock_joint(&name, &q)?;
            }
            locked.push(name);
        }
    }
}
