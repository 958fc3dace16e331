//! One block's part of every table.

/// One block's part of every table.
pub(super) struct Job<'a, T> {
    pub(super) first: usize,
    pub(super) states: usize,
    pub(super) q: &'a mut [T],
    pub(super) v: &'a mut [T],
    pub(super) q_trajectory: &'a mut [T],
    pub(super) v_trajectory: &'a mut [T],
}
