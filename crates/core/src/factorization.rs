//! Factorizations of M that keep a tree's zeros, by entries and by tiles, and dense ones.

pub mod cholesky;
pub mod paths;
pub mod singular_values;
pub mod sparse;
pub mod tile;
pub(crate) mod tree_factor;
