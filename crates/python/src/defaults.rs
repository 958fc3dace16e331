//! The default values of options that the Rust library defines.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::constraints::SupportProblem;
use robot_dynamics::control::InverseKinematicsOptions;
use robot_dynamics::control::optimal::AugmentedLagrangianOptions;
use robot_dynamics::description::RandomRobotOptions;
use robot_dynamics::simulation::SimulationBuilder;
use robot_dynamics::verification::audit;
use robot_dynamics_generate::Request;

use crate::numbers::{object, record};

/// The default values of options that the Rust library defines.
#[pyfunction]
pub(crate) fn _defaults(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let search = InverseKinematicsOptions::default();
    let optimal = AugmentedLagrangianOptions::default();
    let functions = Request::DEFAULT_FUNCTIONS.iter().map(ToString::to_string).collect::<Vec<_>>();
    record(
        py,
        [
            ("dt", object(py, SimulationBuilder::DEFAULT_DT)?),
            ("position_tolerance", object(py, search.position_tolerance)?),
            ("angle_tolerance", object(py, search.angle_tolerance)?),
            ("max_iterations", object(py, search.max_iterations)?),
            ("max_restarts", object(py, search.max_restarts)?),
            ("seed", object(py, search.seed)?),
            ("force_weight", object(py, SupportProblem::DEFAULT_FORCE_WEIGHT)?),
            ("random_joints", object(py, RandomRobotOptions::default().joints)?),
            ("audit_states", object(py, audit::DEFAULT_STATES)?),
            ("audit_seed", object(py, audit::DEFAULT_SEED)?),
            ("optimal_max_iterations", object(py, optimal.inner.max_iterations)?),
            ("optimal_gradient_tolerance", object(py, optimal.inner.gradient_tolerance)?),
            ("optimal_defect_tolerance", object(py, optimal.inner.defect_tolerance)?),
            ("optimal_decrease_tolerance", object(py, optimal.inner.decrease_tolerance)?),
            ("optimal_constraint_tolerance", object(py, optimal.constraint_tolerance)?),
            ("generated_functions", object(py, functions)?),
            ("generated_states", object(py, Request::DEFAULT_STATES)?),
        ],
    )
}
