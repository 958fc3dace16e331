//! Placements, six-vectors and inertias, over any scalar type.

pub mod force;
pub mod inertia;
pub mod motion;
pub mod rotation;
pub mod transform;

#[cfg(test)]
mod algebra_tests;
