//! The Lagrange recipe: the same quantities, slow and obvious, by code that the recursions share nothing of.

pub mod lagrange;
