//! `cargo xtask lab`: the page of experiments, from a fresh clone to an address in the browser.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{cargo, step, tidy};

const TARGET: &str = "wasm32-unknown-unknown";

/// What `cargo xtask lab` is asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Job {
    /// Build and serve; runs until it is stopped.
    Serve,
    /// Write the static site and the single file.
    Build,
    /// Build, then every check: types, lint, unit tests, native against WebAssembly, and a browser.
    Test,
}

/// Builds the lab, and then serves or tests it.
pub(crate) fn run(job: Job) -> Result<(), String> {
    build_module()?;
    install_packages()?;
    step("lab: page", npm(&["run", "build"]))?;
    println!("\nstatic site:  {}", shown("lab/dist/site"));
    println!("single file:  {} (opens without a server)", shown("lab/dist/single/index.html"));
    match job {
        Job::Build => Ok(()),
        Job::Serve => {
            println!("\nopen the address below; Ctrl-C ends it");
            step("lab: serve", npm(&["run", "preview"]))
        }
        Job::Test => {
            step("lab: types", npm(&["run", "check"]))?;
            step("lab: lint", npm(&["run", "lint"]))?;
            step("lab: unit tests, native against WebAssembly", npm(&["run", "test"]))?;
            install_browser()?;
            step("lab: in the browser", npm(&["run", "browser"]))
        }
    }
}

/// The modules of crates/wasm, each by the feature of its name: the page opens with the first and fetches the second
/// when someone comes to a robot.
const MODULES: [&str; 2] = ["chapter", "robots"];

/// crates/wasm to WebAssembly files, and those to modules with their types in lab/wasm.
fn build_module() -> Result<(), String> {
    install_target(TARGET)?;
    for name in MODULES {
        let mut build = cargo(&["build", "--locked", "--package", "wasm", "--lib", "--target", TARGET]);
        build.args(["--profile", "lab", "--no-default-features", "--features", name]);
        step(&format!("lab: physics of the {name}"), build)?;
        let module = target_folder().join(TARGET).join("lab/wasm.wasm");
        let mut bind = cargo(&["run", "--locked", "--package", "lab-builder", "--"]);
        bind.arg(module).arg(tidy::root().join("lab/wasm")).arg(name);
        step(&format!("lab: bindings of the {name}"), bind)?;
    }
    Ok(())
}

/// Rust's library for another kind of machine, where it is not installed.
pub(crate) fn install_target(target: &str) -> Result<(), String> {
    if targets().is_ok_and(|list| list.lines().any(|line| line.trim() == target)) {
        return Ok(());
    }
    let mut add = Command::new("rustup");
    add.args(["target", "add", target]).current_dir(tidy::root());
    step(&format!("Rust for {target}"), add)
}

/// The installed targets of the toolchain in use.
fn targets() -> Result<String, String> {
    let mut list = Command::new("rustup");
    list.args(["target", "list", "--installed"]).current_dir(tidy::root());
    let output = list.output().map_err(|error| format!("cannot start rustup: {error}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn target_folder() -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    tidy::root().join(folder)
}

/// `npm ci`, unless what is installed is what the lock file says.
fn install_packages() -> Result<(), String> {
    let lab = tidy::root().join("lab");
    let written = |path: &str| lab.join(path).metadata().and_then(|data| data.modified()).ok();
    if written("node_modules/.package-lock.json") >= written("package-lock.json") {
        return Ok(());
    }
    step("lab: packages", npm(&["ci", "--no-audit", "--no-fund"]))
}

/// Debian's Chromium, where there is none.
fn install_browser() -> Result<(), String> {
    if Path::new("/usr/bin/chromium").exists() {
        return Ok(());
    }
    install_package("lab", "chromium")
}

/// A package of Debian's.
pub(crate) fn install_package(part: &str, package: &str) -> Result<(), String> {
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    step(&format!("{part}: package lists"), apt(&["update"]))?;
    step(&format!("{part}: {package}"), apt(&["install", "--yes", "--no-install-recommends", package]))
}

fn npm(arguments: &[&str]) -> Command {
    let mut command = Command::new("npm");
    command.args(arguments).current_dir(tidy::root().join("lab"));
    command
}

fn shown(path: &str) -> String {
    tidy::root().join(path).display().to_string()
}
