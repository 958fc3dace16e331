//! The chapter: models, laws, integrators, constraints, rotation, control.

mod constraints;
mod control;
mod integrators;
mod laws;
mod long_runs;
mod lqr;
mod micro_example;
mod models;
mod rapier_agrees;
mod rotation;
