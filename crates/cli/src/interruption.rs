//! Handling of Ctrl-C, SIGTERM and SIGHUP: results so far are shown, and no temporary file remains.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use crate::failure::{Context, Failure};

/// Whether a signal asks the run to end.
static INTERRUPTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// The exit code after a signal, 128 plus its number: 130 for Ctrl-C.
static CODE: AtomicU8 = AtomicU8::new(130);
/// Files and folders to remove when a signal ends the command at once. The lock is held while results are
/// written.
static TO_REMOVE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on a signal only sets the flag that [`interrupted`] reads.
pub(crate) fn end_between_steps() -> Result<(), Failure> {
    on_signal(|code| {
        CODE.store(code, Ordering::Relaxed);
        INTERRUPTED.store(true, Ordering::Release);
    })
}

/// Whether a signal arrived.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Acquire)
}

/// The flag of [`interrupted`], for a computation that polls it.
pub(crate) fn shared_flag() -> Arc<AtomicBool> {
    Arc::clone(&INTERRUPTED)
}

/// The exit code of an interrupted run.
pub(crate) fn code() -> ExitCode {
    ExitCode::from(CODE.load(Ordering::Relaxed))
}

/// Writes results. A signal ends the command before or after, so that all files are complete or none is
/// written.
pub(crate) fn while_writing<T>(write: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    let _held = end_at_once()?;
    write()
}

/// Waits for the end of the command if a signal is ending it. The removal of its files may be the cause of a
/// failure.
pub(crate) fn wait_for_end() {
    drop(TO_REMOVE.lock().unwrap_or_else(PoisonError::into_inner));
}

/// Removes this folder if a signal ends the command.
pub(crate) fn remove_when_ended(folder: &Path) -> Result<(), Failure> {
    end_at_once()?.push(folder.to_owned());
    Ok(())
}

/// From here on a signal ends the command as soon as the lock is free.
fn end_at_once() -> Result<MutexGuard<'static, Vec<PathBuf>>, Failure> {
    static IS_SET: AtomicBool = AtomicBool::new(false);
    let held = TO_REMOVE.lock().unwrap_or_else(PoisonError::into_inner);
    if !IS_SET.swap(true, Ordering::Relaxed) {
        on_signal(|code| {
            let leftovers = TO_REMOVE.lock().unwrap_or_else(PoisonError::into_inner);
            leftovers.iter().for_each(|folder| drop(std::fs::remove_dir_all(folder)));
            std::process::exit(code.into());
        })?;
    }
    Ok(held)
}

/// Calls `act` with the exit code of each signal, on a separate thread.
#[cfg(unix)]
fn on_signal(act: impl Fn(u8) + Send + 'static) -> Result<(), Failure> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let watched =
        [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(SIGHUP));
    let mut signals =
        signal_hook::iterator::Signals::new(watched).context("cannot install signal handlers")?;
    let watch = move || {
        for signal in signals.forever() {
            act(u8::try_from(128 + signal).unwrap_or(130));
        }
    };
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(watch)
        .map(drop)
        .context("cannot install signal handlers")
}

#[cfg(not(unix))]
fn on_signal(act: impl Fn(u8) + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(move || act(130)).context("cannot install a handler for Ctrl-C")
}

/// Whether the parent process made the program ignore the signal, as `nohup` does. Linux reports it in a
/// file.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
