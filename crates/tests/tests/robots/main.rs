//! Descriptions, compiled models and configurations.

#[path = "../../../verification/tests/common/mod.rs"]
mod common;

mod audit;
mod bad_descriptions;
mod checked_methods;
mod configuration;
mod joint_map;
mod quantities;
mod robot_edits;
