//! What is loaded against closed forms, golden numbers and examples.

#![allow(clippy::duplicate_mod)] // each example brings the same drawing along

#[path = "../../examples/03_fastest_motion.rs"]
mod fastest_motion;
#[path = "../../examples/04_identification.rs"]
mod identification;
#[path = "../../examples/05_ilqr/main.rs"]
mod ilqr;
#[path = "../../examples/06_plausibility.rs"]
mod plausibility;
#[path = "../../examples/02_task_control.rs"]
mod task_control;

mod closed_form;
mod closed_loop;
mod examples;
mod golden;
mod optimal_control;
mod panda;
