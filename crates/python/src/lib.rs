//! The native half of the Python package `robot_dynamics`: robots, and arrays of their states.
//!
//! A call passes through these files, from Python to the libraries and back. `rows` has the methods, a line
//! each. `call` decides by the shapes whether one state is meant or many. `operand` turns objects into
//! arrays, and `outcome` turns results into objects. `single_state` computes one state, `batch` many. `ffi`
//! turns memory of numpy into slices.

// The macros need these types, keyword arguments are many, and docstrings have Python's syntax.
#![allow(
    clippy::needless_pass_by_value,
    clippy::too_many_arguments,
    clippy::fn_params_excessive_bools,
    clippy::doc_link_with_quotes
)]

// Exceptions, which the Python half defines.
mod errors;
mod exclusive;

// numpy's memory as slices.
mod ffi;

// Threads, their working memory, and interrupts from Python.
mod interrupts;
mod scratch;
mod threads;

// The robot.
mod assets;
mod number;
mod robot;

// One call of an algorithm on one state or many: its arguments and its results.
mod batch;
mod call;
mod operand;
mod outcome;
mod results;
mod row;
mod single_state;

// All algorithms.
mod rows;

// Functions of one state or of whole motions.
mod certified;
mod checks;
mod clock;
mod constraint_derivatives;
mod constraint_set;
mod constraints;
mod control;
mod controllers;
mod conventions;
mod defaults;
mod description;
mod device;
mod edits;
mod files;
mod fluid;
mod identification;
mod interaction;
mod linearization;
mod numbers;
mod online_motion;
mod optimal;
mod parameters;
mod planning;
mod pullback;
mod rollout;
mod rollout_pullback;
mod scene;
mod sensors;
mod simulation;
mod task_kinematics;

// Calls from programs that XLA compiles, which run without Python.
mod xla;

use pyo3::prelude::*;

/// The native half of `robot_dynamics`; use that package.
// All state is in the robots, which are immutable, or behind locks: the module needs no global interpreter
// lock.
#[pymodule(name = "_native", gil_used = false)]
mod native {
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use super::certified::reach::ReachableSet;
    #[pymodule_export]
    use super::certified::torques::PolynomialMotion;
    #[pymodule_export]
    use super::clock::_nanoseconds;
    #[pymodule_export]
    use super::constraints::Constraints;
    #[pymodule_export]
    use super::control::dlqr;
    #[pymodule_export]
    use super::controllers::{
        ComputedTorque, Delayed, GravityCompensatedPd, ImpedanceControl, ImplicitGains, TaskControl,
        WholeBody,
    };
    #[pymodule_export]
    use super::defaults::_defaults;
    #[pymodule_export]
    use super::description::JointMap;
    #[pymodule_export]
    use super::device::{_contact_links, _device_signature, CpuFunctions, CudaDevice, CudaFunctions};
    #[pymodule_export]
    use super::files::{_html, _random_robot, _visible, _write_text};
    #[pymodule_export]
    use super::identification::BaseParameters;
    #[pymodule_export]
    use super::identification::payload::PayloadFilter;
    #[pymodule_export]
    use super::interaction::{Admittance, ControlAllocation, MomentumObserver};
    #[pymodule_export]
    use super::online_motion::JerkLimitedMotion;
    #[pymodule_export]
    use super::optimal::mpc::OptimalMpc;
    #[pymodule_export]
    use super::optimal::problem::OptimalProblem;
    #[pymodule_export]
    use super::planning::_trajectory_text;
    #[pymodule_export]
    use super::robot::{Robot, example_text};
    #[pymodule_export]
    use super::rows::quantities;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulation::batch::SimulationBatch;
    #[pymodule_export]
    use super::simulation::stepping::{Simulation, Snapshot};
    #[pymodule_export]
    use super::task_kinematics::KinematicTasks;
    #[pymodule_export]
    use super::threads::{num_threads, set_num_threads};
    #[pymodule_export]
    use super::xla::_xla_handlers;
}
