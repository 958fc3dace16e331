//! Control laws. A simulation runs them without Python and calls Python only for a reference that is a
//! function.

mod computed_torque;
mod delayed;
mod frame_task;
mod impedance;
mod implicit_gains;
mod law;
mod pd;
mod task;
mod whole_body;

use pyo3::prelude::*;

use self::law::Controls;
use crate::robot::Robot;

pub(crate) use self::computed_torque::ComputedTorque;
pub(crate) use self::delayed::Delayed;
pub(crate) use self::frame_task::pose_reference;
pub(crate) use self::impedance::ImpedanceControl;
pub(crate) use self::implicit_gains::ImplicitGains;
pub(crate) use self::law::{Law, called_law};
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
    if let Ok(controls) = object.cast::<ImpedanceControl>() {
        return controls.get().law(py, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<ImplicitGains>() {
        let gains = controls.get();
        return gains.around(py, inner_law(py, robot, gains.inner(py))?, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<Delayed>() {
        let late = controls.get();
        return late.around(py, inner_law(py, robot, late.inner(py))?, robot).map(Some);
    }
    if let Ok(controls) = object.cast::<WholeBody>() {
        return controls.get().law(py, robot).map(Some);
    }
    Ok(None)
}

/// The law that another one contains: a controller of the library, or a Python function.
fn inner_law<'a>(py: Python<'_>, robot: &'a Robot, object: &Bound<'_, PyAny>) -> PyResult<Law<'a>> {
    Ok(law_of(py, robot, object)?.unwrap_or_else(|| called_law(object, robot)))
}
