//! The recursions and their derivatives, against closed forms and each other.

#[path = "../../../verification/tests/common/mod.rs"]
mod common;

mod closed_forms;
mod consistent_identification;
mod coriolis;
mod excitation;
mod golden;
mod identification;
mod joint_reactions;
mod joint_terms;
mod kinematics;
mod long_slides;
mod lqr;
mod nonlinear_identification;
mod not_finite;
mod payload;
mod pullback;
mod rank;
mod regressor;
mod sensors;
