//! Robots with closed loops.

#[path = "../../../robot-dynamics/examples/01_closed_loop.rs"]
mod closed_loop;
#[path = "../common/mod.rs"]
mod common;

mod constrained_motion;
mod constrained_variational;
mod derivatives;
mod examples;
mod inverse;
mod row_jacobians;
mod rows;
mod support;
