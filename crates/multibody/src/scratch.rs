//! The memory that the algorithms work in, and what runs an algorithm on it.

pub(crate) mod branch_block;
pub(crate) mod compiled_once;
pub(crate) mod derivatives;
pub(crate) mod extent;
pub(crate) mod freedoms;
pub(crate) mod momentum_block;
pub(crate) mod native;
pub(crate) mod passes;
pub(crate) mod pullback;
pub(crate) mod slope;
pub(crate) mod tree;
pub(crate) mod workspace;
