//! `Simulation`: active effects, method, and single steps against runs.

mod active_effects;
#[cfg(feature = "adaptive")]
mod adaptive;
mod batch;
mod hopper;
mod measurements;
mod momentum;
mod pairs;
mod stepping;
