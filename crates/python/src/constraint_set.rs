//! Constraints of one robot.

use pyo3::prelude::*;
use robot_dynamics::constraints::ConstraintSet;

/// Constraints of one robot, by name.
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct Constraints {
    pub(crate) set: ConstraintSet,
    pub(crate) fingerprint: u64,
    pub(crate) robot: String,
}
