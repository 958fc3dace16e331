//! Stopping with Ctrl-C: what was computed is still shown.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

use crate::failure::{Context, Failure};

static INTERRUPTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// The exit code of a program ended by Ctrl-C: 128 + SIGINT.
pub(crate) const CODE: u8 = 130;

/// From here on Ctrl-C ends nothing by itself; [`interrupted`] says that it was pressed.
pub(crate) fn watch() -> Result<(), Failure> {
    ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed)).context("cannot watch for Ctrl-C")
}

/// Whether Ctrl-C was pressed.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// The same for a computation that looks at it by itself.
pub(crate) fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}

/// The same for one that keeps it.
pub(crate) fn shared_flag() -> Arc<AtomicBool> {
    Arc::clone(&INTERRUPTED)
}
