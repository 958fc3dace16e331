//! Cargo's commands, and the folder where it builds.

use std::path::PathBuf;
use std::process::Command;

use crate::root::root;

/// A cargo command for all crates with all features, so that each dependency is compiled once: for a single
/// package it would have fewer features and be compiled again. The lab's builder has no tests.
pub(crate) fn workspace(command: &str) -> Command {
    checked(&[command, "--workspace", "--exclude", "lab-builder", "--all-features", "--locked"])
}

/// Where cargo builds.
pub(crate) fn target_folder() -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    root().join(folder)
}

/// Keeps LLVM from recording which references do not alias at every inlined call, a fifth of the time that
/// the recursions take to compile.
pub(crate) const UNNOTED: &str = "-C llvm-args=-enable-noalias-to-md-conversion=false";

/// A cargo command whose programs are tested, not timed. Lints and documentation share flags, build scripts
/// and procedural macros with the tests.
pub(crate) fn checked(arguments: &[&str]) -> Command {
    let mut command = cargo(arguments);
    let theirs = std::env::var("RUSTFLAGS").unwrap_or_default();
    command.env("RUSTFLAGS", format!("{theirs} {UNNOTED}").trim_start());
    command
}

pub(crate) fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
}
