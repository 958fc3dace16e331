//! Runs of operations whose symbols repeat with a period: the candidates for loops.

use std::collections::BinaryHeap;

/// Iterations of a loop at least: robots with four legs or five fingers get no loops.
pub(super) const LEAST_ITERATIONS: usize = robot_dynamics_functions::LEAST_EQUAL_LINKS;

/// Operations that a loop must save.
pub(super) const LEAST_SAVED: usize = 32;

/// Positions `start..end` whose symbols have a period; ordered by the operations that a loop can save.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PeriodicRun {
    saved: usize,
    /// Among equals, the earlier run is larger.
    pub(super) start: core::cmp::Reverse<usize>,
    pub(super) end: usize,
    pub(super) period: usize,
}

impl PeriodicRun {
    /// The run, if it is long enough for a loop.
    pub(super) fn new(start: usize, end: usize, period: usize) -> Option<Self> {
        let length = end.saturating_sub(start);
        let saved = length.saturating_sub(period);
        let is_long = length >= LEAST_ITERATIONS * period && saved >= LEAST_SAVED;
        is_long.then_some(Self { saved, start: core::cmp::Reverse(start), end, period })
    }

    /// The runs that are left where some of its positions are taken.
    pub(super) fn free_parts(&self, taken: &[bool]) -> Vec<Self> {
        let mut parts = Vec::new();
        let mut start = self.start.0;
        for at in self.start.0..=self.end {
            if at == self.end || taken[at] {
                parts.extend(Self::new(start, at, self.period));
                start = at + 1;
            }
        }
        parts
    }
}

/// The longest range around two positions in which each symbol equals the one a period later: its start, and
/// the end of the later one.
pub(super) fn extend(symbols: &[u32], place: usize, at: usize) -> (usize, usize) {
    let period = at - place;
    let mut start = place;
    while start > 0 && symbols[start - 1] == symbols[start - 1 + period] {
        start -= 1;
    }
    let mut end = at;
    while end < symbols.len() && symbols[end] == symbols[end - period] {
        end += 1;
    }
    (start, end)
}

/// The number of positions in at least one run.
pub(super) fn covered(runs: &BinaryHeap<PeriodicRun>, count: usize) -> usize {
    let mut changes = vec![0_isize; count + 1];
    for run in runs {
        changes[run.start.0] += 1;
        changes[run.end] -= 1;
    }
    let runs_at = changes.iter().scan(0, |runs, change| {
        *runs += change;
        Some(*runs)
    });
    runs_at.filter(|&runs| runs > 0).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_extend_to_the_first_symbol_out_of_period() {
        let symbols = [9, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 8];
        for (place, at) in [(1, 4), (4, 7), (2, 5), (6, 9)] {
            assert_eq!(extend(&symbols, place, at), (1, 11));
        }
        assert_eq!(extend(&symbols, 1, 7), (1, 11));
    }

    #[test]
    fn taken_positions_are_cut_out_of_runs() {
        let run = PeriodicRun::new(0, 200, 4).unwrap();
        let mut taken = vec![false; 200];
        taken[60..100].fill(true);
        taken[120] = true;
        let parts: Vec<_> = run.free_parts(&taken).iter().map(|part| (part.start.0, part.end)).collect();
        // The part between 100 and 120 is too short.
        assert_eq!(parts, [(0, 60), (121, 200)]);
    }

    #[test]
    fn positions_in_several_runs_are_counted_once() {
        let runs =
            [(0, 100), (50, 150), (160, 220)].map(|(start, end)| PeriodicRun::new(start, end, 1).unwrap());
        assert_eq!(covered(&runs.into_iter().collect(), 300), 150 + 60);
    }
}
