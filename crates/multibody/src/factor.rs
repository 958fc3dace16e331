//! Factors of M with the zeros that a tree leaves, entry by entry and by tiles; and of what is no tree.

pub(crate) mod cholesky;
pub(crate) mod paths;
pub(crate) mod singular_values;
pub(crate) mod sparse;
pub(crate) mod tile;
pub(crate) mod tree_factor;
