//! The time of one call of a function, from many.

use std::time::Instant;

/// The number of runs of each function, of which the fastest counts.
pub(super) const RUNS: usize = 7;

/// The shortest duration of a run \[s\].
pub(super) const LEAST_DURATION: f64 = 0.004;

/// Nanoseconds of one call.
pub(super) fn fastest(mut calls: impl FnMut(usize)) -> f64 {
    let mut time = |count: usize| {
        let start = Instant::now();
        calls(count);
        start.elapsed().as_secs_f64()
    };
    let mut count = 1;
    while time(count) < LEAST_DURATION {
        count *= 2;
    }
    #[allow(clippy::cast_precision_loss)] // calls of a few milliseconds
    let one = |time: f64| 1e9 * time / count as f64;
    (0..RUNS).map(|_| one(time(count))).fold(f64::INFINITY, f64::min)
}
