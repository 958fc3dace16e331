//! The ground of a simulation, by the arguments of the Python half.

use robot_dynamics::contact::ContactSet;
use robot_dynamics::height_field;

use crate::robot::Robot;

/// Refuses a robot whose file has neither height fields nor planes in its world.
pub(super) fn check_file_ground(robot: &Robot) -> Result<(), String> {
    let contacts = ContactSet::with_meshes(&robot.model, &[], |_| Err("meshes are no ground".into()))
        .and_then(|contacts| contacts.with_described_planes(&robot.model))
        .and_then(|contacts| contacts.with_described_height_fields(&robot.model, height_field))
        .map_err(|error| error.to_string())?;
    if contacts.height_field_count() + contacts.ground_count() > 0 {
        return Ok(());
    }
    let left_out = contacts.left_out().join("; ");
    Err(format!(
        "ground=\"file\": the file of robot `{}` has no height field and no plane that the world carries{}{left_out}",
        robot.model.name(),
        if left_out.is_empty() { "" } else { ": " }
    ))
}

pub(super) fn no_such_ground(name: &str) -> String {
    format!(
        "ground={name:?}: give a Ground, a HeightField, or \"file\" for the height fields of the robot's file"
    )
}
