//! The recursions and their derivatives, against closed forms and each other.

#[path = "../../../verification/tests/common/mod.rs"]
mod common;

mod closed_forms;
mod coriolis;
mod golden;
mod identification;
mod joint_reactions;
mod kinematics;
mod long_slides;
mod lqr;
mod not_finite;
mod pullback;
mod rank;
mod regressor;
mod sensors;
