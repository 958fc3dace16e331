//! The public API against the last release, by `cargo-semver-checks`.

use std::process::Command;

use crate::cargo::cargo;
use crate::layers::libraries;
use crate::manifest::Manifest;
use crate::root::root;
use crate::step::step;

/// Compares the published libraries with the last tag `v*`.
pub(crate) fn run() -> Result<(), String> {
    let Some(tag) = git(&["describe", "--tags", "--abbrev=0", "--match", "v*"])? else {
        println!("semver: there is no tag v* to compare with");
        return Ok(());
    };
    let mut check = cargo(&["semver-checks", "--baseline-rev", tag.trim()]);
    for library in libraries() {
        let manifest = Manifest::read(library)?;
        let package = manifest.package()?;
        let released = git(&["show", &format!("{}:crates/{library}/Cargo.toml", tag.trim())])?;
        if !manifest.is_published() {
            println!("semver: {package} is not published");
        } else if released.is_none_or(|text| !text.contains(&format!("name = \"{package}\""))) {
            println!("semver: {package} is new since {}", tag.trim());
        } else {
            check.args(["--package", package]);
        }
    }
    if check.get_args().all(|argument| argument != "--package") {
        println!("semver: no library to compare with {}", tag.trim());
        return Ok(());
    }
    let version = cargo(&["semver-checks", "--version"]).output();
    if !version.is_ok_and(|output| output.status.success()) {
        step("semver: cargo-semver-checks", cargo(&["install", "cargo-semver-checks", "--locked"]))?;
    }
    step("semver", check)
}

/// The output of a git command, nothing if it fails.
fn git(arguments: &[&str]) -> Result<Option<String>, String> {
    let mut command = Command::new("git");
    command.args(arguments).current_dir(root());
    let output = command.output().map_err(|error| format!("cannot start git: {error}"))?;
    Ok(output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned()))
}
