//! Steps, runs, events and their linearisation.

#[path = "../../../verification/tests/common/mod.rs"]
mod common;

mod actuation;
mod actuator_loads;
#[cfg(feature = "adaptive")]
mod adaptive;
mod bad_input;
mod ball_stops;
mod closed_forms;
mod components;
mod contact;
mod contact_step;
mod controllers;
mod divergence;
mod equalities;
mod events;
mod fluid;
mod free_body;
mod gimbal;
mod height_field;
mod held_torques;
mod implicit;
mod linearize_by_differences;
mod linearize_constraints;
mod linearize_impacts;
mod linearize_step;
mod linearize_stepper;
mod links;
mod long_chains;
mod motors;
mod moving_surfaces;
mod path_stops;
mod pullback;
mod simulation;
mod soft_law;
mod spatial_tendons;
mod step_parameters;
mod stepper_pullback;
mod tendon_stops;
mod transmissions;
mod tree_integrators;
mod yielding_springs;
