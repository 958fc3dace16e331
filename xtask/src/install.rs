//! Installs the programs that the checks need, where they are missing.

use std::process::Command;
use std::sync::Mutex;

use crate::root::root;
use crate::step::step;

/// Installs Rust's standard library for another target, where it is missing.
pub(crate) fn install_target(target: &str) -> Result<(), String> {
    if targets().is_ok_and(|list| list.lines().any(|line| line.trim() == target)) {
        return Ok(());
    }
    let mut add = Command::new("rustup");
    add.args(["target", "add", target]).current_dir(root());
    step(&format!("Rust for {target}"), add)
}

/// The installed targets of the toolchain in use.
fn targets() -> Result<String, String> {
    let mut list = Command::new("rustup");
    list.args(["target", "list", "--installed"]).current_dir(root());
    let output = list.output().map_err(|error| format!("cannot start rustup: {error}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether a program is installed.
pub(crate) fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok()
}

/// Debian's installer runs one command at a time.
static INSTALLER: Mutex<()> = Mutex::new(());

/// Installs a Debian package.
pub(crate) fn install_package(part: &str, package: &str) -> Result<(), String> {
    let _alone = INSTALLER.lock();
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    step(&format!("{part}: package lists"), apt(&["update"]))?;
    step(&format!("{part}: {package}"), apt(&["install", "--yes", "--no-install-recommends", package]))
}
