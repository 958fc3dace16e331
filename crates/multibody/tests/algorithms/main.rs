//! The recursions and their derivatives, against the Lagrange recipe, closed forms and each other.

#[path = "../common/mod.rs"]
mod common;

mod closed_forms;
mod coriolis;
mod derivatives;
mod dispatch_paths;
mod golden;
mod identification;
mod kinematics;
mod long_slides;
mod lqr;
mod momentum;
mod not_finite;
mod oracles;
mod pullback;
mod rank;
mod regressor;
