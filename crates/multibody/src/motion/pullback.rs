//! Pullbacks of motion: of one step, and of a rollout through time.
//!
//! A step takes (q₀, v₀, τ) to (q₁, v₁). From cotangents (q̄₁, v̄₁), gradients of some loss by the end, come those by the start,
//! the force and the parameters: the transposed rows of [`linearize_step`](crate::linearize_step), which are not formed. A
//! rollout goes from its last step to its first. Steps back need the states that were passed: those at every `spacing`-th
//! step are kept, those between are computed again from there, one more run of the whole.
//!
//! Source: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.2 and 12 (checkpoints).

mod allocating;
pub(crate) mod course;
mod error;
mod rollout;
pub(crate) mod stages;
mod step;

pub use allocating::{ForwardPullback, InversePullback};
pub use error::PullbackError;
pub use rollout::{Rollout, RolloutPullbackWorkspace, rollout_pullback};
pub use step::{StepPullbackWorkspace, step_pullback};
