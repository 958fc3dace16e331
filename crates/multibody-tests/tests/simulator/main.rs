//! One simulation: what acts, by which method, and steps from outside against runs.

mod acts;
#[cfg(feature = "adaptive")]
mod adaptive;
mod batch;
mod hopper;
mod measurements;
mod momentum;
mod pairs;
mod stepping;
