//! One benchmark: its task, and its time in every round.

use robot_dynamics::quantity::Quantity;

use super::batch::Work;
use super::{batch, single_states};

/// The floating-point type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    Double,
    Single,
}

impl Precision {
    pub(super) const ALL: [Self; 2] = [Self::Double, Self::Single];

    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Double => "f64",
            Self::Single => "f32",
        }
    }
}

/// The task of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Task {
    /// One state after the other, on one thread.
    Single(Quantity),
    /// A batch.
    Batch { work: Work, precision: Precision, threads: usize },
}

/// A task and its times.
pub(super) struct Entry {
    pub(super) what: Task,
    /// Index of the next state.
    pub(super) cursor: usize,
    /// For each round, the median time of its blocks \[ns per state, or per step of a rollout\].
    pub(super) rounds: Vec<f64>,
    /// The reason for a missing result.
    pub(super) trouble: Option<String>,
}

/// The median, the minimum and the maximum of the rounds \[ns\], and the number of rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Time {
    pub(super) median: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) rounds: usize,
}

impl Time {
    /// Half the range of the rounds over their median.
    pub(super) fn spread(self) -> f64 {
        (self.most - self.least) / (2.0 * self.median)
    }

    /// States or steps per second.
    pub(super) fn per_second(self) -> f64 {
        1e9 / self.median
    }
}

/// The median; of an even count the lower of the two middle numbers.
pub(super) fn median(numbers: &mut [f64]) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len().saturating_sub(1) / 2).copied()
}

impl Entry {
    /// All tasks in the order of the report: single states, batches, rollouts, and batches of forward
    /// dynamics on numbers of threads between one and all.
    pub(super) fn all(threads: &[usize]) -> Vec<Self> {
        let mut all: Vec<Task> = single_states::QUANTITIES.into_iter().map(Task::Single).collect();
        let ends = [threads.first(), threads.last()];
        let mut ends: Vec<usize> = ends.into_iter().flatten().copied().collect();
        ends.dedup();
        let rollouts = batch::ROLLOUTS.map(Work::Rollout);
        for work in batch::QUANTITIES.into_iter().map(Work::Compute).chain(rollouts) {
            for precision in Precision::ALL {
                all.extend(ends.iter().map(|&threads| Task::Batch { work, precision, threads }));
            }
        }
        let has_batches = !batch::QUANTITIES.is_empty();
        let between = threads.iter().filter(|threads| has_batches && !ends.contains(threads));
        all.extend(between.map(|&threads| Task::Batch {
            work: SCALING_WORK,
            precision: Precision::Double,
            threads,
        }));
        let entry = |what| Self { what, cursor: 0, rounds: Vec::new(), trouble: None };
        all.into_iter().map(entry).collect()
    }

    /// The time over all rounds, `None` before the first.
    pub(super) fn time(&self) -> Option<Time> {
        let mut rounds = self.rounds.clone();
        let median = median(&mut rounds)?;
        Some(Time { median, least: *rounds.first()?, most: *rounds.last()?, rounds: rounds.len() })
    }
}

/// The task that shows how time falls with the number of threads.
pub(super) const SCALING_WORK: Work = Work::Compute(Quantity::ForwardDynamics);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_of_its_rounds() {
        let mut entry = Entry::all(&[1]).swap_remove(0);
        assert_eq!(entry.time(), None);
        entry.rounds = vec![4.0, 2.0, 3.0];
        let time = entry.time().unwrap();
        assert_eq!(time, Time { median: 3.0, least: 2.0, most: 4.0, rounds: 3 });
        assert!((time.spread() - 1.0 / 3.0).abs() < 1e-15 && (time.per_second() - 1e9 / 3.0).abs() < 1e-6);
        entry.rounds = vec![7.0, 5.0];
        assert_eq!(entry.time().unwrap().median, 5.0);
    }

    /// 9 tasks of one state. 6 quantities and 2 integrators, each in 2 precisions and on one and all threads.
    /// Then the numbers of threads between.
    #[cfg(feature = "batch")]
    #[test]
    fn the_list_grows_with_the_threads() {
        let counts = [&[1][..], &[1, 2], &[1, 2, 4, 6]].map(|threads| Entry::all(threads).len());
        assert_eq!(counts, [9 + 16, 9 + 32, 9 + 32 + 2]);
    }
}
