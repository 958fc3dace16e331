//! Inverse kinematics, operational-space control, LQR, time-optimal paths and identification of parameters.

mod dof_limits;
pub mod identification;
mod inverse_kinematics;
pub mod joint_trajectory;
mod lqr;
mod momentum_observer;
pub mod online_motion;
mod operational_space;
pub mod optimal;
mod quadratic_program;
mod rotation_vector;
pub mod task_kinematics;
pub mod time_parameterization;
pub mod whole_body;

mod admittance;
mod control_allocation;

pub use admittance::Admittance;
pub use control_allocation::ControlAllocation;
pub use identification::{
    BaseParameter, BaseParameters, IdentificationError, IdentificationResult, LinkConsistency, MotionRecord,
    inertial_parameter_names, physical_consistency, pseudo_inertia,
};
pub use inverse_kinematics::{
    FrameTarget, InverseKinematicsError, InverseKinematicsOptions, InverseKinematicsSolution,
    inverse_kinematics,
};
pub use lqr::{Dlqr, DlqrError, dlqr};
pub use momentum_observer::MomentumObserver;
pub use operational_space::{
    ComputedTorque, EffortScales, ImpedanceControl, ImpedanceGains, OperationalSpace, OperationalSpaceInputs,
    OperationalSpaceWorkspace, PoseReference, Reference, TaskControl, TaskDeviation, TaskGains,
    TaskReference, TaskTarget, operational_space, operational_space_into,
};
pub use time_parameterization::{
    Collocation, CubicSpline, LimitUtilization, MotionLimits, ParameterizationError, PathCoefficients,
    PathState, TimeOptimal, TimedPath, TreePath, TreePathPoint, limit_utilization, path_coefficients,
    time_optimal,
};
