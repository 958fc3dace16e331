//! Motion in time: one step of an integrator, the table of integrators, and the energy ledger of a run.
//!
//! Every step advances M q̈ + C q̇ + g + b = u from (q, q̇) by h seconds with u held over the step.
//!
//! | row | order | symplectic | reversible | energy over a long run |
//! | --- | --- | --- | --- | --- |
//! | explicit Euler | 1 | never | no | grows, at first order |
//! | semi-implicit Euler | 1 | where M is constant | no | bounded only where M is constant |
//! | classical Runge–Kutta | 4 | never | no | drifts, slowly and steadily |
//! | variational midpoint | 2 | always | yes | error bounded, O(h²) |
//! | variational Yoshida | 4 | always | yes | error bounded, O(h⁴) |
//!
//! "Symplectic" and "bounded" hold for u = 0 or u = −∂V/∂q of some V, and b = 0.

mod energy;
mod error;
pub(crate) mod explicit;
mod method;
mod table;
mod variational;

pub use energy::{EnergyLedger, EnergyRun, energy_drift, energy_run, energy_scale};
pub use error::IntegratorError;
pub use explicit::{State, explicit_euler_step, rk4_step, semi_implicit_euler_step};
pub use method::{Method, Stage};
pub use table::{Integrator, Symplectic};
pub use variational::{variational_midpoint_step, variational_yoshida4_step};
