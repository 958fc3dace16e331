//! Integration methods as tables, and the energy account of a run.
//!
//! A step of an explicit method is a sequence of [`Stage`]s; a step of a structure-preserving method is a
//! sequence of variational midpoint steps. One table, [`Integrator`], serves systems of fixed size, trees,
//! batches and derivatives.
//!
//! | row | order | symplectic | reversible | energy over a long run |
//! | --- | --- | --- | --- | --- |
//! | explicit Euler | 1 | never | no | grows, at first order |
//! | semi-implicit Euler | 1 | if M is constant | no | bounded only if M is constant |
//! | classical Runge–Kutta | 4 | never | no | drifts, slowly and steadily |
//! | variational midpoint | 2 | always | yes | error bounded, O(h²) |
//! | variational Yoshida | 4 | always | yes | error bounded, O(h⁴) |
//!
//! "Symplectic" and "bounded" hold for u = 0 or u = −∂V/∂q of some V, and b = 0.

mod energy;
mod error;
mod name;
mod scheme;
mod table;

pub use energy::{EnergyAccount, energy_scale};
pub use error::{IntegratorError, check_computed};
pub use scheme::{Stage, StepScheme};
pub use table::{Integrator, Symplectic};
