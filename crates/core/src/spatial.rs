//! Placements, six-vectors and inertias, over any scalar type.

pub mod screw;
pub mod turn;

#[cfg(test)]
mod algebra_tests;
