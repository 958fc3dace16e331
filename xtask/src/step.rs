//! One command of the checks: printed, timed, and its failure an error.

use std::cell::Cell;
use std::fs::{self, File};
use std::io::Write;
use std::process::{Command, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use crate::cargo::target_folder;

thread_local! {
    /// Whether this thread's steps run beside others: each holds its output until it has ended.
    static IS_BESIDE: Cell<bool> = const { Cell::new(false) };
}

/// Whether a step has failed while others ran beside it: then no further step begins.
static HAS_FAILED: AtomicBool = AtomicBool::new(false);

/// Runs a command and prints how long it took.
pub(crate) fn step(name: &str, mut command: Command) -> Result<(), String> {
    if HAS_FAILED.load(Ordering::Relaxed) {
        return Err(format!("{name}: not begun, as what ran beside it failed"));
    }
    let start = Instant::now();
    let status = if IS_BESIDE.get() {
        println!("\n== {name}, beside the rest: {command:?}");
        kept_back(name, &mut command)
    } else {
        println!("\n== {name}: {command:?}");
        command.status()
    };
    let status = status.map_err(|error| format!("{name}: cannot start {command:?}: {error}"))?;
    println!(
        "== {name}: {} after {:.0} s",
        if status.success() { "ok" } else { "FAILED" },
        start.elapsed().as_secs_f64()
    );
    if status.success() { Ok(()) } else { Err(format!("{name} failed: {command:?}")) }
}

/// Runs it, and prints its output when it has ended.
fn kept_back(name: &str, command: &mut Command) -> std::io::Result<ExitStatus> {
    let folder = target_folder();
    fs::create_dir_all(&folder)?;
    let path = folder.join("beside.txt");
    let said = File::create(&path)?;
    let status = command.stdout(said.try_clone()?).stderr(said).status()?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "\n== {name}, beside the rest, output:")?;
    out.write_all(&fs::read(&path)?)?;
    Ok(status)
}

/// Runs these checks on a thread beside what follows.
pub(crate) fn beside(
    checks: impl FnOnce() -> Result<(), String> + Send + 'static,
) -> JoinHandle<Result<(), String>> {
    thread::spawn(|| {
        IS_BESIDE.set(true);
        noted(checks())
    })
}

/// The result; a failure keeps further steps from beginning.
pub(crate) fn noted(result: Result<(), String>) -> Result<(), String> {
    if result.is_err() {
        HAS_FAILED.store(true, Ordering::Relaxed);
    }
    result
}
