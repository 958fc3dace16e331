//! `Simulation`: active effects, method, and single steps against runs.

mod acts;
#[cfg(feature = "adaptive")]
mod adaptive;
mod batch;
mod hopper;
mod measurements;
mod momentum;
mod pairs;
mod stepping;
