//! Loaded robots against closed forms, golden numbers and examples.

#![allow(clippy::duplicate_mod)] // each example includes the same drawing module

#[path = "../../../robot-dynamics/examples/03_fastest_motion.rs"]
mod fastest_motion;
#[path = "../../../robot-dynamics/examples/04_identification.rs"]
mod identification;
#[path = "../../../robot-dynamics/examples/05_ilqr/main.rs"]
mod ilqr;
#[path = "../../../robot-dynamics/examples/06_plausibility.rs"]
mod plausibility;
#[path = "../../../robot-dynamics/examples/02_task_control.rs"]
mod task_control;

mod closed_form;
mod closed_loop;
mod examples;
mod golden;
mod optimal_control;
mod panda;
