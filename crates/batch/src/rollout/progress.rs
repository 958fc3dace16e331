//! The progress of a rollout, and its cancellation.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The progress of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RolloutProgress {
    /// Completed steps over all states.
    pub done: u64,
    /// The total number of steps over all states.
    pub total: u64,
}

impl RolloutProgress {
    /// The progress of a rollout that is computed outside this crate.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::batch::RolloutProgress::new(64, 1000).done, 64);
    /// ```
    pub const fn new(done: u64, total: u64) -> Self {
        Self { done, total }
    }
}

/// A callback for the progress of a rollout, which can cancel it, called occasionally from any thread.
pub type RolloutObserver<'a> = &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync);

/// The observer of a rollout that is not observed: it never cancels.
///
/// ```
/// use robot_dynamics::batch::{RolloutProgress, UNOBSERVED};
/// assert!(UNOBSERVED(RolloutProgress::new(64, 1000)).is_continue());
/// ```
pub const UNOBSERVED: RolloutObserver<'static> = &|_| ControlFlow::Continue(());

/// The data that all threads of a rollout share.
pub(crate) struct SharedProgress<'a> {
    progress: RolloutObserver<'a>,
    done: AtomicU64,
    total: u64,
    cancelled: AtomicBool,
}

impl<'a> SharedProgress<'a> {
    /// For this number of steps over all states.
    pub(super) fn new(progress: RolloutObserver<'a>, total: u64) -> Self {
        Self { progress, done: AtomicU64::new(0), total, cancelled: AtomicBool::new(false) }
    }

    /// Whether the callback has cancelled the rollout.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// For one step of one state, whose progress is not counted.
    #[cfg(feature = "native")]
    pub(super) fn of_one_step() -> Self {
        Self::new(UNOBSERVED, 1)
    }

    /// Counts completed steps; returns whether to continue.
    pub(super) fn go_on(&self, steps: u64) -> bool {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        if !self.cancelled.load(Ordering::Relaxed)
            && (self.progress)(RolloutProgress { done, total: self.total }).is_break()
        {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        !self.cancelled.load(Ordering::Relaxed)
    }
}
