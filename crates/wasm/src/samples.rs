//! Recent samples of a run over simulated time, for trails and plots.

use std::collections::VecDeque;

/// Rows of `W` numbers, the first of them the time \[s\]; the oldest are dropped.
#[derive(Clone, Debug)]
pub(crate) struct Samples<const W: usize> {
    rows: VecDeque<[f64; W]>,
    capacity: usize,
    every: u64,
}

impl<const W: usize> Samples<W> {
    /// One row every `interval` \[s\] of a run with steps of `step` \[s\], at most `capacity` rows.
    pub(crate) fn new(interval: f64, step: f64, capacity: usize) -> Self {
        // Saturates: an interval shorter than a step samples every step.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let every = (interval / step).round().max(1.0) as u64;
        Self { rows: VecDeque::with_capacity(capacity), capacity, every }
    }

    /// Whether a row belongs to this step.
    pub(crate) fn due(&self, step: u64) -> bool {
        step.is_multiple_of(self.every)
    }

    pub(crate) fn push(&mut self, row: [f64; W]) {
        if self.rows.len() == self.capacity {
            self.rows.pop_front();
        }
        self.rows.push_back(row);
    }

    pub(crate) fn clear(&mut self) {
        self.rows.clear();
    }

    /// All rows, one after the other.
    pub(crate) fn flat(&self) -> Vec<f64> {
        self.rows.iter().flatten().copied().collect()
    }
}
