//! The algorithms on batches, generic over the float: what [`BatchFloat`](crate::BatchFloat) compiles once.

pub(crate) mod derivatives;
pub(crate) mod frames;
pub(crate) mod operation;
pub(crate) mod pullback;
pub(crate) mod recursions;
pub(crate) mod related_mass;
