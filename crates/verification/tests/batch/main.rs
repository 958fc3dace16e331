//! Batches of states.

#[path = "../common/mod.rs"]
mod common;

mod batch_derivatives;
mod calls;
mod pullback;
mod related_mass;
mod rollouts;
mod stepper_rollouts;
