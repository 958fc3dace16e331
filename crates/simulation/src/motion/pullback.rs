//! Pullbacks of one step and of a rollout.
//!
//! A step maps (q₀, v₀, τ) to (q₁, v₁). The pullback maps cotangents (q̄₁, v̄₁), gradients of a loss by the
//! end state, to those by the initial state, the force and the parameters. It applies the transposes of the
//! matrices of [`linearize_step`](crate::linearize_step) without forming them. The pullback of a rollout
//! proceeds from its last step to its first and needs the states in between. It stores the states of every
//! `spacing`-th step and recomputes the others from there, at the cost of one more rollout.
//!
//! Steps with contact multiply the cotangents by Aᵀ and Bᵀ of
//! [`linearize_stepper`](crate::linearize_stepper) (`stepper`).
//!
//! Source: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.2 and 12 (checkpoints).

pub mod checkpoints;
mod checks;
mod cotangents;
pub mod rollout;
mod rollout_pullback;
pub mod stages;
mod step;
mod stepper;
pub mod stepper_checkpoints;
mod stepper_rollout;
mod tables;

pub use cotangents::{MotionCotangents, TrajectoryCotangents};
pub use rollout::Rollout;
pub use rollout_pullback::{RolloutPullbackWorkspace, rollout_pullback};
pub use step::{StepPullbackWorkspace, step_pullback};
pub use stepper::{rollout_pullback_by_stepper, stepper_pullback};
pub use stepper_checkpoints::StepperPullbackWorkspace;
pub use stepper_rollout::StepperRollout;
