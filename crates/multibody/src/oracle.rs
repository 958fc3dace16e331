//! The Lagrange recipe, and contact's law by another method: the same quantities, slow and obvious, by code that the fast ones share nothing of.

pub mod admm;
pub mod lagrange;
