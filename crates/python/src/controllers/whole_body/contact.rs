//! Held contacts.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use robot_dynamics::control::whole_body::{ContactGeometry, HeldContact};

use crate::errors::exception;
use crate::numbers::{several, shaped};
use crate::robot::Robot;

/// The contact that an object describes.
pub(super) fn contact_of(py: Python<'_>, robot: &Robot, object: &Bound<'_, PyAny>) -> PyResult<HeldContact> {
    let Ok(geometry) = object.getattr("geometry") else {
        let found = object.get_type().name()?;
        let message = format!("a contact must be a HeldContact of robot_dynamics.whole_body, got {found}");
        return Err(PyTypeError::new_err(message));
    };
    let frame = robot.frame_of(&object.getattr("frame")?)?;
    let number = |name: &str| object.getattr(name)?.extract::<f64>();
    let (friction, sides) = (number("friction")?, object.getattr("sides")?.extract()?);
    let damping = number("damping")?;
    let normal = several("the normal", &object.getattr("normal")?)?;
    let [smallest, largest] = several("normal_force", &object.getattr("normal_force")?)?;
    HeldContact::new(frame, geometry_of(py, &geometry)?)
        .with_normal(normal)
        .and_then(|contact| contact.with_friction(friction, sides))
        .and_then(|contact| contact.with_normal_force(smallest, largest))
        .and_then(|contact| contact.with_damping(damping))
        .map_err(exception)
}

fn geometry_of(py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<ContactGeometry> {
    let kind = object.getattr("_kind").and_then(|kind| kind.extract::<String>());
    match kind.as_deref() {
        Ok("point") => {
            Ok(ContactGeometry::Point(several("the offset of the point", &object.getattr("offset")?)?))
        }
        Ok("ball") => Ok(ContactGeometry::Ball(object.getattr("radius")?.extract()?)),
        Ok("face") => {
            let given = object.getattr("corners")?;
            let (_, corners) = shaped(py, "the corners of the face", &given, &[usize::MAX, 3])?;
            let corners = corners.chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]);
            Ok(ContactGeometry::Face(corners.collect()))
        }
        _ => {
            let found = object.get_type().name()?;
            let message = format!(
                "the geometry of a contact must be a Point, Ball or Face of robot_dynamics.whole_body, got {found}"
            );
            Err(PyTypeError::new_err(message))
        }
    }
}
