//! Motion in time: one step of an integrator, and the energy of a run.
//!
//! Every step advances M q̈ + C q̇ + g + b = u from (q, q̇) by h seconds with u held over the step. The
//! methods are the rows of [`Integrator`](crate::Integrator).

mod energy;
pub(crate) mod explicit_stages;
mod step;
mod variational_midpoint;

pub use energy::{EnergyRun, SystemEnergy, energy_drift, energy_run};
pub use explicit_stages::{State, explicit_euler_step, rk4_step, semi_implicit_euler_step};
pub use step::SystemStep;
pub use variational_midpoint::{variational_midpoint_step, variational_yoshida4_step};
