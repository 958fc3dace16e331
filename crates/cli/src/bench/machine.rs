//! What the numbers belong to: the machine, its instructions, and how this program was built.

use serde::Serialize;

/// The machine and the program.
#[derive(Serialize)]
pub(super) struct Machine {
    pub(super) processor: String,
    pub(super) threads: usize,
    pub(super) system: String,
    /// Threads that were busy in the minute before, where the system tells it.
    pub(super) load_before: Option<f64>,
    /// "release" or "debug".
    pub(super) build: &'static str,
    pub(super) version: &'static str,
    /// The instructions of a single state, and of batches.
    pub(super) single_instructions: String,
    pub(super) batch_instructions: String,
    pub(super) lanes_f64: usize,
    pub(super) lanes_f32: usize,
}

/// Whether the compiler was told to check what a release does not.
pub(super) const IS_DEBUG: bool = cfg!(debug_assertions);

/// The processor's name, where the system tells it.
pub(super) fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    known.unwrap_or_else(|| format!("unnamed {} processor", std::env::consts::ARCH))
}

/// The load average of the last minute.
pub(super) fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// One thread, then doubled, then all.
pub(super) fn thread_counts(all: usize) -> Vec<usize> {
    let mut counts: Vec<usize> =
        core::iter::successors(Some(1), |n: &usize| n.checked_mul(2)).take_while(|&n| n < all).collect();
    counts.push(all);
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_double_up_to_all() {
        assert_eq!(
            [1, 2, 6, 8].map(thread_counts),
            [vec![1], vec![1, 2], vec![1, 2, 4, 6], vec![1, 2, 4, 8]]
        );
        assert!(!processor().is_empty());
    }
}
