//! The command `dynamics` as static binaries for Linux, in archives and in Debian packages, with manual pages
//! and shell completions.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{SMALL, with_ending};
use crate::cargo::{cargo, target_folder};
use crate::install::install_target;
use crate::root::root;
use crate::step::step;
use crate::versions::workspace_version;

/// The targets, and the variable that names their linker. Rust's own linker needs no cross compiler.
const TARGETS: [(&str, &str); 2] = [
    ("x86_64-unknown-linux-musl", "CARGO_TARGET_X86_64_UNKNOWN_LINUX_MUSL_LINKER"),
    ("aarch64-unknown-linux-musl", "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER"),
];

/// Shells, and the names under which they find a script for `dynamics`.
const SHELLS: [(&str, &str); 3] = [("bash", "dynamics"), ("zsh", "_dynamics"), ("fish", "dynamics.fish")];

/// The version of the program that writes Debian packages.
const CARGO_DEB: &str = "3.8.0";

/// Builds archives and Debian packages into the folder.
pub(super) fn make(folder: &Path) -> Result<Vec<PathBuf>, String> {
    install_cargo_deb()?;
    let own = TARGETS.iter().position(|(target, _)| target.starts_with(std::env::consts::ARCH));
    let own = own.ok_or("this machine runs none of the static binaries")?;
    for (target, linker) in TARGETS {
        install_target(target)?;
        let mut build = cargo(&["rustc", "--release", "--locked", "--package", "robot-dynamics-cli"]);
        build.args(SMALL).args(["--bin", "dynamics", "--target", target, "--", "-C", "strip=symbols"]);
        build.env(linker, "rust-lld");
        step(&format!("release: command for {target}"), build)?;
    }
    let program = built(TARGETS[own].0).join("dynamics");
    let version = workspace_version()?;
    for (target, _) in TARGETS {
        write_texts(&program, &built(target))?;
        archive(&built(target), &format!("dynamics-{version}-{target}"), folder)?;
        let mut deb =
            cargo(&["deb", "--no-build", "--no-strip", "--locked", "--package", "robot-dynamics-cli"]);
        deb.args(["--target", target, "--output"]).arg(folder);
        step(&format!("release: Debian package for {target}"), deb)?;
    }
    let mut files = with_ending(folder, ".tgz", "dynamics-")?;
    files.extend(with_ending(folder, ".deb", "robot-dynamics")?);
    Ok(files)
}

/// Where cargo builds for a target.
fn built(target: &str) -> PathBuf {
    target_folder().join(target).join("release")
}

fn install_cargo_deb() -> Result<(), String> {
    let version = cargo(&["deb", "--version"]).output();
    if version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains(CARGO_DEB)) {
        return Ok(());
    }
    step("release: cargo-deb", cargo(&["install", "cargo-deb", "--locked", "--version", CARGO_DEB]))
}

/// The manual pages and the scripts for shells, as the command prints them.
fn write_texts(program: &Path, folder: &Path) -> Result<(), String> {
    let mut pages = Command::new(program);
    pages.args(["man", "--output"]).arg(folder.join("man"));
    step("release: manual pages", pages)?;
    let completions = folder.join("completions");
    fs::create_dir_all(&completions).map_err(|error| format!("{}: {error}", completions.display()))?;
    for (shell, name) in SHELLS {
        let output = Command::new(program).args(["completions", shell]).output();
        let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
        if !output.status.success() {
            return Err(format!("{} completions {shell} failed", program.display()));
        }
        let path = completions.join(name);
        fs::write(&path, output.stdout).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// An archive with one folder: the program, its pages and scripts, and the licences.
fn archive(from: &Path, name: &str, folder: &Path) -> Result<(), String> {
    let staged = folder.join(name);
    fs::create_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    let copy = |source: PathBuf, to: PathBuf| {
        fs::copy(&source, to).map(drop).map_err(|error| format!("{}: {error}", source.display()))
    };
    copy(from.join("dynamics"), staged.join("dynamics"))?;
    copy(root().join("crates/cli/README.md"), staged.join("README.md"))?;
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        copy(root().join(licence), staged.join(licence))?;
    }
    for part in ["man", "completions"] {
        fs::create_dir_all(staged.join(part)).map_err(|error| error.to_string())?;
        for entry in fs::read_dir(from.join(part)).map_err(|error| error.to_string())?.flatten() {
            copy(entry.path(), staged.join(part).join(entry.file_name()))?;
        }
    }
    let mut tar = Command::new("tar");
    tar.args(["--create", "--gzip", "--file"]).arg(folder.join(format!("{name}.tgz")));
    tar.args(["--owner=0", "--group=0", "--numeric-owner", "--directory"]).arg(folder).arg(name);
    step(&format!("release: archive {name}"), tar)?;
    fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))
}
