//! The Python package: pip builds it into its own environment; then its tests, types and stubs are checked.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cargo::target_folder;
use crate::install::install_package;
use crate::root::root;
use crate::step::step;

/// Oldest Python that the package is for.
const OLDEST: (u32, u32) = (3, 11);

/// The differences that stubs may have, with reasons.
const ALLOWED: &str = "stubtest-allowlist.txt";

/// Builds the package and checks it.
pub(crate) fn run() -> Result<(), String> {
    let folder = root().join("python");
    let python = environment(&target_folder().join("python"))?;
    let run = |arguments: &[&str]| {
        let mut command = Command::new(&python);
        // With `-P` Python imports the installed package, not the sources in this folder.
        command.arg("-P").args(arguments).current_dir(&folder).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    };
    let mut install = run(&["-m", "pip", "install", "--quiet", "--disable-pip-version-check", ".[test]"]);
    // A fixed target folder makes the second build quick.
    install.env("CARGO_TARGET_DIR", target_folder()).env("MATURIN_PEP517_ARGS", "--locked");
    step("python: the package by pip", install)?;
    step("python: tests", run(&["-m", "pytest", "--quiet", "-p", "no:cacheprovider"]))?;
    step("python: stubs are current", run(&["stubs.py", "--check"]))?;
    step(
        "python: stubs are true",
        run(&[
            "-m",
            "mypy.stubtest",
            "robot_dynamics",
            "--mypy-config-file",
            "pyproject.toml",
            "--allowlist",
            ALLOWED,
        ]),
    )?;
    step("python: types", run(&["-m", "mypy", "--strict", "--package", "robot_dynamics"]))?;
    step(
        "python: types of a user's program",
        run(&["-m", "mypy", "--strict", "tests", "examples", "stubs.py"]),
    )
}

/// The interpreter of a virtual environment, which is created if it is missing.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf, String> {
    let inside = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };
    let python = folder.join("venv").join(inside);
    if !works(&python, "import pip") {
        let system = system_python()?;
        let mut make = Command::new(&system);
        make.args(["-m", "venv", "--clear"]).arg(folder.join("venv"));
        step("python: environment", make)?;
    }
    Ok(python)
}

/// A Python that can create environments: the system's, or else Debian's.
fn system_python() -> Result<PathBuf, String> {
    let (major, minor) = OLDEST;
    let can = format!("import sys, venv, ensurepip; sys.exit(sys.version_info < ({major}, {minor}))");
    let names = ["python3", "python"];
    let find = || names.iter().map(PathBuf::from).find(|python| works(python, &can));
    if let Some(python) = find() {
        return Ok(python);
    }
    install_package("python", "python3-venv")?;
    find().ok_or_else(|| {
        format!("the Python package needs Python {major}.{minor} or later with its module `venv`")
    })
}

/// Whether that interpreter runs a command without an error.
fn works(python: &Path, words: &str) -> bool {
    let output = Command::new(python).args(["-c", words]).output();
    output.is_ok_and(|output| output.status.success())
}
