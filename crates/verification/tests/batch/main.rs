//! Batches of states.

#[path = "../common/mod.rs"]
mod common;

mod batch_derivatives;
mod by_stepper;
mod calls;
mod pullback;
mod related_mass;
mod rollouts;
