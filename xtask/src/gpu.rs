//! `cargo xtask test gpu`: batches on a device. Without a GPU the device is Mesa's lavapipe, Vulkan on the
//! processor.

use std::fs;
use std::process::Command;

use crate::cargo::{target_folder, workspace};
use crate::install::install_package;
use crate::step::step;

/// Tells the tests that there is a device: without one they fail instead of skipping.
const EXPECTED: &str = "ROBOT_DYNAMICS_DEVICE";

/// Runs the tests on a device, and the example.
pub(crate) fn run() -> Result<(), String> {
    install_driver()?;
    let mut test = workspace("test");
    test.args(["--test", "device", "--test", "cuda"]);
    step("gpu: tests", expecting_a_device(test))?;
    let mut build = workspace("build");
    build.args(["--example", "rollout"]);
    step("gpu: example", build)?;
    example("rollout")
}

/// A command that runs tests, which fail without a device if lavapipe is installed.
pub(crate) fn expecting_a_device(mut command: Command) -> Command {
    if is_driver_there() {
        command.env(EXPECTED, "1");
    }
    command
}

/// Debian's drivers with Vulkan, where lavapipe is missing.
pub(crate) fn install_driver() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        println!(
            "\n== gpu: a driver is installed on Debian alone; elsewhere the tests skip if there is none"
        );
        return Ok(());
    }
    if is_driver_there() { Ok(()) } else { install_package("gpu", "mesa-vulkan-drivers") }
}

/// Whether there is lavapipe.
fn is_driver_there() -> bool {
    ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"].iter().any(|folder| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name()).any(|name| name.to_string_lossy().starts_with("lvp_icd"))
    })
}

/// Runs an example that the test run has compiled.
pub(crate) fn example(name: &str) -> Result<(), String> {
    let file = format!("debug/examples/{name}{}", std::env::consts::EXE_SUFFIX);
    step(&format!("example {name}"), expecting_a_device(Command::new(target_folder().join(file))))
}
