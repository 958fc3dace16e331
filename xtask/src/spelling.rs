//! Spelling, by `typos`: `_typos.toml` lists the project's words.

use std::process::Command;

use crate::cargo::target_folder;
use crate::python;
use crate::root::root;
use crate::step::step;

/// The program's version, from the Python package index, which has it compiled for each system.
const VERSION: &str = "1.52.0";

/// Checks the spelling of the tree.
pub(crate) fn run() -> Result<(), String> {
    let python = python::environment(&target_folder().join("typos"))?;
    let typos = python.with_file_name(if cfg!(windows) { "typos.exe" } else { "typos" });
    let version = Command::new(&typos).arg("--version").output();
    let is_current = version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains(VERSION));
    if !is_current {
        let mut install = Command::new(&python);
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        install.arg(format!("typos=={VERSION}"));
        step("spelling: typos by pip", install)?;
    }
    let mut check = Command::new(typos);
    check.args(["--format", "brief"]).current_dir(root());
    step("spelling", check)
}
