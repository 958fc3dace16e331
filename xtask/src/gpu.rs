//! `cargo xtask test gpu`: batches on a device. Where there is no other it is Mesa's lavapipe, a Vulkan of the processor's.

use std::fs;

use crate::cargo;
use crate::install::install_package;
use crate::step::step;

/// Says to the tests that there is a device: without one they fail instead of passing over.
const EXPECTED: &str = "ROBOT_DYNAMICS_DEVICE";

/// Runs the crate's tests, doc tests and example.
pub(crate) fn run() -> Result<(), String> {
    let is_installed = cfg!(target_os = "linux");
    if is_installed {
        install_driver()?;
    } else {
        println!(
            "\n== gpu: a driver is installed on Debian alone; elsewhere the tests pass over where there is none"
        );
    }
    let with_device = |arguments: &[&str]| {
        let mut command = cargo(arguments);
        if is_installed {
            command.env(EXPECTED, "1");
        }
        // The compiler would take longer than the tests: with fewer features than the whole workspace all is compiled again.
        command.env("CARGO_PROFILE_DEV_OPT_LEVEL", "1");
        command
    };
    let package = ["--package", "robot-dynamics-gpu", "--all-features", "--locked"];
    step("gpu: tests and doc tests", with_device(&[&["test"][..], &package].concat()))?;
    let example = ["run", "--example", "rollout"];
    step("gpu: example", with_device(&[&example[..], &package].concat()))
}

/// Debian's drivers with Vulkan, where lavapipe is missing.
fn install_driver() -> Result<(), String> {
    let is_there = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"].iter().any(|folder| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name()).any(|name| name.to_string_lossy().starts_with("lvp_icd"))
    });
    if is_there { Ok(()) } else { install_package("gpu", "mesa-vulkan-drivers") }
}
