//! Control laws. A simulation runs them without Python and calls Python only for a reference that is a
//! function.

mod computed_torque;
mod law;
mod pd;
mod task;
mod whole_body;

use pyo3::prelude::*;

use self::law::Controls;
use crate::robot::Robot;

pub(crate) use self::computed_torque::ComputedTorque;
pub(crate) use self::law::Law;
pub(crate) use self::pd::GravityCompensatedPd;
pub(crate) use self::task::TaskControl;
pub(crate) use self::whole_body::WholeBody;

/// The law for this robot, if the object is one.
pub(crate) fn law_of<'a>(
    py: Python<'_>,
    robot: &'a Robot,
    object: &Bound<'_, PyAny>,
) -> PyResult<Option<Law<'a>>> {
    if let Ok(controls) = object.cast::<GravityCompensatedPd>() {
        return controls.get().law(py, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<ComputedTorque>() {
        return controls.get().law(py, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<TaskControl>() {
        return controls.get().law(py, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<WholeBody>() {
        return controls.get().law(py, robot).map(Some);
    }
    Ok(None)
}
