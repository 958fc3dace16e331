//! Control and planning.

#[path = "../../../verification/tests/common/mod.rs"]
mod common;

mod actuated;
mod configuration_spline;
mod control_allocation;
mod interaction;
mod inverse_kinematics;
mod joint_trajectory;
mod online_motion;
mod operational_space;
mod optimal;
mod owning_controllers;
mod task_kinematics;
mod time_limits;
mod time_optimal;
mod whole_body;
