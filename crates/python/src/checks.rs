//! Checks the laws of dynamics on one robot, and finds numbers that suggest a wrong unit.

use pyo3::prelude::*;
use robot_dynamics::plausibility::suspicions;
use robot_dynamics::verification::audit::{Verdict, audit, ignored_physics};

use crate::robot::Robot;

/// Name, law, found, relation, allowed, whether it holds, where.
type CheckFields = (String, String, f64, &'static str, f64, bool, String);

#[pymethods]
impl Robot {
    /// See `audit`.
    fn _audit(&self, py: Python<'_>, states: u32, seed: u64) -> Vec<CheckFields> {
        let mut checks = py.detach(|| audit(&self.model, states, seed));
        checks.push(ignored_physics(&self.report));
        let fields = |check: robot_dynamics::verification::audit::Check| {
            let holds = check.verdict == Verdict::Ok;
            (check.name, check.law, check.found, check.relation, check.allowed, holds, check.place)
        };
        checks.into_iter().map(fields).collect()
    }

    /// See `suspicions`.
    fn _suspicions(&self) -> Vec<String> {
        let found = suspicions(self.model.description(), &self.angles);
        found.iter().map(ToString::to_string).collect()
    }
}
