//! Proven bounds of a robot's quantities, by interval arithmetic.
//!
//! [`Interval`] is a [`Scalar`](robot_dynamics_number::Scalar). Recursions over scalars have no branch on a
//! value, so each of them runs over intervals: the results contain the exact values for every state in a box.
//! Constants are those of the compiled model, in double precision.
//!
//! | item | contents |
//! | --- | --- |
//! | [`Interval`] | a closed interval with outward rounding |
//! | [`forward_dynamics`] | an enclosure of a, by an approximate inverse of M |
//! | [`solve`] | an enclosure of the solutions of M x = b for all M and b in intervals |
//! | [`is_positive_definite`] | a proof that every symmetric matrix in an interval matrix is positive definite |
//! | [`enclose_state`] | enclosures of all quantities at a state, and the digits that double precision has |
//! | [`mass_matrix_definiteness`] | a proof that M is positive definite in a box of configurations |
//! | [`ReachableSet`] | a convex set that contains every position of a frame |
//! | [`enclose_motion`] | enclosures of free motions from sets of states |
//! | [`torque_bounds`] | bounds of the torques of a motion for a set of robots |
//! | [`Uncertainty`], [`Payload`] | such sets: masses, payload, friction and gravity in intervals |
//! | [`PolynomialMotion`] | a motion as polynomials in time |
//!
//! # Rounding
//! - A sum has the error e of TwoSum (Knuth, *The Art of Computer Programming* 2, §4.2.2), which is exact
//!   unless the sum overflows: a + b = s + e. The lower bound is s if e ≥ 0, and the number below s
//!   otherwise. This is the sum rounded down. It is exact if the sum is.
//! - A product, a quotient or a root x̂ is rounded to nearest. The exact x is then between the neighbours of
//!   x̂, as x̂ is the nearest number to x, also if it underflows or overflows. The bounds are these neighbours.
//!   A product with 0 or ±1 is exact.
//! - Sine and cosine: x − k π/2 is computed in intervals, with π/2 as a sum of three numbers, the first two
//!   of 30 bits. k has at most 22 bits, so their products with k are exact. A Taylor polynomial follows, in
//!   intervals, with the remainder of Lagrange. Between the bounds of a wide interval lies an extremum only
//!   if an interval that contains x/(π/2) contains an integer.
//!
//! Sources: Moore, Kearfott, Cloud, *Introduction to Interval Analysis*, SIAM 2009; Rump, *Verification
//! methods*, Acta Numerica 19 (2010).

mod certificate;
mod definite;
mod digits;
mod elementary;
mod flow;
mod interval;
mod linear;
mod motion;
mod reach;
mod scalar;
mod search;
mod series;
mod support;
mod torque;
mod uncertainty;

pub use certificate::{Certificate, NoCertificate};
pub use definite::{Definiteness, mass_matrix_definiteness};
pub use digits::{EnclosedQuantity, EnclosedState, enclose_state};
pub use flow::{FlowEnclosure, FlowState, enclose_motion};
pub use interval::Interval;
pub use linear::{EnclosureError, forward_dynamics, is_positive_definite, solve};
pub use motion::{InvalidMotion, Piece, Polynomial, PolynomialMotion};
pub use reach::{Farthest, ReachableSet};
pub use search::{Divisions, SearchOptions};
pub use torque::{Attained, TimePart, TorqueBounds, torque_bounds};
pub use uncertainty::{InvalidUncertainty, Payload, Uncertainty};

/// The Python program that checks certificates without this library.
pub const CHECKER: &str = include_str!("../checker/check_certificate.py");

/// The code of the front page, compiled and run with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
