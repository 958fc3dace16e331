//! The machine, its instructions, and the build of this program.

use serde::Serialize;

/// The machine and the program.
#[derive(Serialize)]
pub(super) struct Machine {
    pub(super) processor: String,
    pub(super) threads: usize,
    pub(super) system: String,
    /// Load average of the minute before, if the system provides it.
    pub(super) load_before: Option<f64>,
    /// "release" or "debug".
    pub(super) build: &'static str,
    pub(super) version: &'static str,
    /// Instruction sets for a single state and for batches.
    pub(super) single_instructions: String,
    pub(super) batch_instructions: String,
    pub(super) lanes_f64: usize,
    pub(super) lanes_f32: usize,
}

/// Whether this is a debug build.
pub(super) const IS_DEBUG: bool = cfg!(debug_assertions);

/// The processor's name, if the system provides it.
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

/// 1, 2, 4, … and `all`.
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
