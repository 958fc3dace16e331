//! Wheels of the Python package for Linux, and its source distribution, by maturin.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{SMALL, with_ending};
use crate::cargo::target_folder;
use crate::install::install_target;
use crate::python;
use crate::root::root;
use crate::step::step;

/// The versions of the builder and of the compiler and linker for old systems, from PyPI.
const TOOLS: [&str; 2] = ["maturin==1.16.0", "ziglang==0.17.1"];

/// The processors of the wheels.
const TARGETS: [&str; 2] = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"];

/// The oldest C library: that of RHEL 8, Debian 10 and Ubuntu 18.10.
const COMPATIBILITY: &str = "manylinux_2_28";

/// Builds the wheels and the source distribution into the folder.
pub(super) fn make(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let python = python::environment(&target_folder().join("wheels"))?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(TOOLS);
    step("release: maturin and zig by pip", install)?;
    for target in TARGETS {
        install_target(target)?;
        let mut build = maturin(&python, "build");
        build.args(["--release", "--locked", "--zig", "--compatibility", COMPATIBILITY]);
        // One binary for this version and later ones.
        build.args(["--interpreter", "python3.11", "--target", target]).args(SMALL);
        build.args(["--compression-level", "9", "--out"]).arg(folder);
        step(&format!("release: wheel for {target}"), build)?;
    }
    let mut sources = maturin(&python, "sdist");
    sources.arg("--out").arg(folder);
    step("release: source distribution", sources)?;
    let mut files = with_ending(folder, ".whl", "robot_dynamics-")?;
    files.extend(with_ending(folder, ".tar.gz", "robot_dynamics-")?);
    Ok(files)
}

fn maturin(python: &Path, command: &str) -> Command {
    let mut maturin = Command::new(python);
    maturin.args(["-m", "maturin", command]).current_dir(root().join("python"));
    maturin.env("CARGO_TARGET_DIR", target_folder());
    // Python needs its zig on the path.
    let mut paths: Vec<PathBuf> = python.parent().map(Path::to_path_buf).into_iter().collect();
    paths.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    if let Ok(joined) = std::env::join_paths(paths) {
        maturin.env("PATH", joined);
    }
    maturin
}
