//! The memory of the algorithms, and the dispatch of an algorithm on it.

pub(crate) mod branch_block;
pub mod buffers;
pub mod compiled_once;
pub mod derivatives;
pub mod dof_blocks;
pub mod extent;
pub(crate) mod momentum_block;
pub mod motion_derivatives;
pub mod native;
pub mod passes;
pub mod pullback;
pub mod tree;
