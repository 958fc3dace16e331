//! The numbers that an algorithm writes for one state.

/// The most operands that an algorithm has.
pub(crate) const MOST_OPERANDS: usize = 5;

/// The most results that an algorithm has.
pub(crate) const MOST_RESULTS: usize = 4;

/// The results of one state, a slice for each.
pub(crate) type Results<'a> = [&'a mut [f64]; MOST_RESULTS];
