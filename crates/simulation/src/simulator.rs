//! A simulation of one robot with every effect that its description states.
//!
//! Each step of fixed length h integrates
//!
//! ```text
//! M(q) v̇ + C(q, v) v + g(q) + b(v) = τ + τ_actuators + τ_springs + Aᵀλ + Σ Jᵀw
//! ```
//!
//! where b is damping and dry friction, λ are the multipliers of equalities, limits and contacts, and w are
//! the wrenches on frames.
//! [`SimulationBuilder`] selects the effects and the method; [`Simulation`] takes the steps.

mod active_effects;
#[cfg(feature = "adaptive")]
mod adaptive;
mod assembly;
mod builder;
mod effect;
mod error;
mod held_inputs;
mod inputs;
mod link_pairs;
mod measurements;
mod memory;
mod method;
mod own_stepper;
mod results;
mod run_options;
mod runs;
#[cfg(feature = "native")]
pub mod simultaneous_steps;
mod state;
mod step_inputs;
mod stepping;
mod unsupported_features;
mod wrench;

pub use crate::motion::simulate::Observer;
pub use builder::SimulationBuilder;
pub use effect::{Effect, UnknownEffect};
pub use error::SimulationError;
pub use method::{Method, SimulationStepper, UnknownMethod};
pub use run_options::{RunOptions, SampleInterval};
pub use state::Snapshot;
pub use stepping::Simulation;
pub use unsupported_features::UnsupportedFeatures;
pub use wrench::AppliedWrench;
