//! Long work that Python may interrupt.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use pyo3::prelude::*;
use robot_dynamics::batch::RolloutProgress;

/// How often the waiting thread checks for an interrupt.
const PATIENCE: Duration = Duration::from_millis(50);

/// Up to this many steps of all states together, the calling thread does the work and does not check for
/// interrupts.
pub(crate) const FEW_STEPS: usize = 10_000;

/// Does work without the interpreter's lock. An interrupt sets the flag that the work gets, and becomes the
/// error.
///
/// Python handles signals in its main thread. Unless the work is short, the calling thread therefore waits
/// while another thread works.
pub(crate) fn interruptible<R: Send>(
    py: Python<'_>,
    is_short: bool,
    work: impl FnOnce(&AtomicBool) -> R + Send,
) -> PyResult<R> {
    let cancelled = AtomicBool::new(false);
    if is_short {
        return Ok(py.detach(|| work(&cancelled)));
    }
    interruptible_by(py, &cancelled, || work(&cancelled))
}

/// The same for work that checks this flag.
pub(crate) fn interruptible_by<R: Send>(
    py: Python<'_>,
    flag: &AtomicBool,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let (send, receive) = mpsc::channel();
    let mut signal = None;
    let outcome = std::thread::scope(|scope| {
        let worker = scope.spawn(move || {
            let outcome = work();
            // The receiver may be gone.
            let _ = send.send(());
            outcome
        });
        let receive = std::sync::Mutex::new(receive);
        while !worker.is_finished() {
            let is_done = py.detach(|| {
                receive.lock().is_ok_and(|receive| {
                    !matches!(receive.recv_timeout(PATIENCE), Err(mpsc::RecvTimeoutError::Timeout))
                })
            });
            if is_done {
                break;
            }
            if let Err(error) = py.check_signals() {
                flag.store(true, Ordering::Relaxed);
                signal = Some(error);
                break;
            }
        }
        py.detach(|| worker.join())
    });
    match (outcome, signal) {
        (Err(panic), _) => std::panic::resume_unwind(panic),
        (Ok(_), Some(signal)) => Err(signal),
        (Ok(outcome), None) => Ok(outcome),
    }
}

/// A rollout's progress that goes on until the flag is set.
pub(crate) fn until(cancelled: &AtomicBool) -> impl Fn(RolloutProgress) -> ControlFlow<()> + Sync + '_ {
    |_| if cancelled.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
