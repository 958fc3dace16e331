//! A flag that interrupts a computation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The flag, if there is one. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Option<Arc<AtomicBool>>);

impl Interrupt {
    pub fn new(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    /// Whether there is a flag.
    pub(crate) fn is_watched(&self) -> bool {
        self.0.is_some()
    }

    /// Whether the flag is set.
    #[inline]
    pub(crate) fn is_set(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
