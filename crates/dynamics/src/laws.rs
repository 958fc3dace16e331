//! The laws that every mechanical system obeys, written once and checked on every model.
//!
//! A model is right when these identities hold, whatever its formulas look like:
//!
//! | law | statement |
//! | --- | --- |
//! | mass | M = Mᵀ, M ≻ 0; column j of M is what inverse dynamics says of q̈ = eⱼ |
//! | kinetic energy | K = ½ q̇ᵀM q̇ and E = K + V |
//! | gravity | g = ∂V/∂q |
//! | velocity product | C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q, quadratic in q̇ |
//! | skew symmetry | Ṁ − 2C is skew-symmetric, Ṁ computed without C |
//! | round trips | forward ∘ inverse = inverse ∘ forward = identity |
//! | dissipation | b·q̇ ≥ 0 |
//! | power balance | dE/dt = u·q̇ − b·q̇ |
//!
//! [`check`] needs a [`Dynamics`](crate::Dynamics) only and differentiates by differences; [`check_all`] also wants the
//! [`Lagrangian`](crate::Lagrangian) and repeats every law that has a derivative in it with exact ones.
//! The states are seeded ([`States`]), and a broken law reports the state that broke it.
//!
//! ```
//! use dynamics::{PlanarArm, laws};
//! laws::check_all("Reach3R", &PlanarArm::reach_3r(), &laws::States::new(1)).unwrap();
//! ```
//!
//! # Tolerances
//! Identities without a derivative must hold to `k·ε` of the terms they add up, times κ(M) = λmax/λmin
//! where M is inverted, with k = 16 + 4N counting the operations in a row of M. Difference quotients
//! are of eighth order with step h = 0.01; along one unit of q the M of a chain of N joints turns by at
//! most ω = 2√N radians, so they must agree to (hω)⁸ω/630 + 100 ε/h of the terms: 2e-12 for N = 3,
//! 4e-10 for N = 30. M counts as positive definite while κ(M) ≤ 0.1/ε, beyond which a solve has no digit.

mod any;
mod differences;
mod exact;
mod states;
mod violation;

pub use any::check;
pub use exact::check_all;
pub use states::{Sample, States};
pub use violation::{Report, Violation};
