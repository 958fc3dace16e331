//! Factorizations of M that keep a tree's zeros, by entries and by tiles, and dense ones.
//!
//! | file | factor | cost | for |
//! | --- | --- | --- | --- |
//! | `sparse` | M = LᵀDL **(RBDA §6.5)** | O(n depth²) | solving, inverting |
//! | `tree_factor` | the same in tiles of rows | O(n depth²) | the many right sides of derivatives |
//! | `paths` | the same in packed rows | O(n depth²) | implicit steps and contacts |
//! | `cholesky` | M = LLᵀ | O(n³) | small dense systems |
//! | `singular_values` | B V = UΣ | O(n³) per sweep | ranks and least norms |
//!
//! None of them checks its pivots: an M that is not positive definite gives numbers that are not finite.
//! `algorithms::rank` finds singular M beforehand.

pub mod cholesky;
pub mod paths;
pub mod singular_values;
pub mod sparse;
pub mod tile;
pub(crate) mod tree_factor;
