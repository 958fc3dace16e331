//! Commands of CMake.

use std::path::Path;
use std::process::Command;

/// Configures a project in a build folder.
pub(crate) fn configure(source: &Path, build: &Path) -> Command {
    let mut command = Command::new("cmake");
    command.arg("-S").arg(source).arg("-B").arg(build);
    command
}

/// Builds a configured project.
pub(crate) fn build(folder: &Path) -> Command {
    let mut command = Command::new("cmake");
    command.arg("--build").arg(folder).args(["--parallel", "2"]);
    command
}

/// Installs a built project.
pub(crate) fn install(folder: &Path, prefix: &Path) -> Command {
    let mut command = Command::new("cmake");
    command.arg("--install").arg(folder).arg("--prefix").arg(prefix);
    command
}

/// Runs the tests of a built project.
pub(crate) fn test(folder: &Path) -> Command {
    let mut command = Command::new("ctest");
    command.arg("--output-on-failure").current_dir(folder);
    command
}
