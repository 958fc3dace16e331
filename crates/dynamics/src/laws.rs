//! The laws that every mechanical system obeys, written once and checked on every model.
//!
//! A model is correct if these identities hold, whatever its formulas:
//!
//! | law | statement |
//! | --- | --- |
//! | mass | M = Mᵀ, M ≻ 0; column j of M is the inverse dynamics of q̈ = eⱼ |
//! | kinetic energy | K = ½ q̇ᵀM q̇ and E = K + V |
//! | gravity | g = ∂V/∂q |
//! | velocity product | C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q, quadratic in q̇ |
//! | skew symmetry | Ṁ − 2C is skew-symmetric, Ṁ computed without C |
//! | round trips | forward ∘ inverse = inverse ∘ forward = identity |
//! | dissipation | b·q̇ ≥ 0 |
//! | power balance | dE/dt = u·q̇ − b·q̇ |
//!
//! [`check`] needs only a [`Dynamics`](crate::Dynamics) and differentiates by differences. [`check_all`] also
//! needs the [`Lagrangian`](crate::Lagrangian) and repeats every law that contains a derivative with exact
//! ones. The states are seeded ([`States`]), and a violation reports its state.
//!
//! ```
//! use dynamics::{PlanarArm, laws};
//! laws::check_all("Reach3R", &PlanarArm::reach_3r(), &laws::States::new(1)).unwrap();
//! ```
//!
//! # Tolerances
//! Identities without a derivative must hold to `k·ε` of the terms that they sum, times κ(M) = λmax/λmin
//! where M is inverted. k = 16 + 4N is the number of operations in a row of M. Difference quotients are of
//! eighth order with step h = 0.01. Along one unit of q the M of a chain of N joints turns by at most ω = 2√N
//! radians. They must therefore agree to (hω)⁸ω/630 + 100 ε/h of the terms: 2e-12 for N = 3, 4e-10 for
//! N = 30. M counts as positive definite if κ(M) ≤ 0.1/ε; beyond that a solve has no correct digit.

mod differences;
mod exact_derivatives;
mod identities;
mod states;
mod violation;

pub use exact_derivatives::check_all;
pub use identities::check;
pub use states::{Sample, States};
pub use violation::{Report, Violation};
