//! The robot, the lengths and the parameters of a call.

use std::collections::HashMap;
use std::sync::{PoisonError, RwLock};

use pyo3::prelude::*;
use robot_dynamics::derivatives::parameter_count;

use crate::ffi::xla::XlaCall;
use crate::robot::Robot;

/// The robots that programs call, by their fingerprints. They are never dropped, because the end of the last
/// program is not reported.
static ROBOTS: RwLock<Option<HashMap<u64, &'static Robot>>> = RwLock::new(None);

#[pymethods]
impl Robot {
    /// The number by which programs of XLA call this robot. It stays in memory from now on.
    fn _xla_handle(slf: &Bound<'_, Self>) -> u64 {
        let fingerprint = slf.get().model.fingerprint();
        let mut robots = ROBOTS.write().unwrap_or_else(PoisonError::into_inner);
        let robots = robots.get_or_insert_default();
        robots.entry(fingerprint).or_insert_with(|| Box::leak(Box::new(slf.clone().unbind())).get());
        fingerprint
    }
}

/// The robot of a call.
pub(super) fn robot_of(call: &XlaCall<'_>) -> Result<&'static Robot, String> {
    let handle = call.whole("robot")?;
    let robots = ROBOTS.read().unwrap_or_else(PoisonError::into_inner);
    let robot = robots.as_ref().and_then(|robots| robots.get(&handle)).copied();
    robot.ok_or_else(|| "this program was compiled for a robot that is not loaded in this process".to_owned())
}

pub(super) const NOT_FLOATS: &str = "all arrays must be float64, or all float32";

/// A length that is not negative.
pub(super) fn length(dim: i64) -> usize {
    usize::try_from(dim).unwrap_or(0)
}

/// The parameters of a call that has them as its last array: one row for all states, or a row each.
pub(super) fn parameters_of<'a, T>(
    robot: &Robot,
    has_parameters: bool,
    states: usize,
    read: &mut Vec<&'a [T]>,
) -> Result<Option<&'a [T]>, String> {
    if !has_parameters {
        return Ok(None);
    }
    let parameters = read.pop().unwrap_or_default();
    let count = parameter_count(&robot.model);
    if parameters.len() == count || parameters.len() == count * states {
        return Ok(Some(parameters));
    }
    Err(format!(
        "robot `{}` has {count} parameters, the call has {} numbers",
        robot.model.name(),
        parameters.len()
    ))
}
