//! The integrations with ROS 2, Octave and Julia, tested against an installed C++ library.

use std::path::Path;
use std::process::Command;

use crate::cmake;
use crate::install::is_there;
use crate::root::root;
use crate::step::step;

/// Tests ROS 2 by stubs of its headers, Octave where it is installed, and Julia by its signatures.
pub(crate) fn run(prefix: &Path, folder: &Path) -> Result<(), String> {
    project("ros2/test", prefix, &folder.join("ros2"))?;
    if is_there("mkoctfile") && is_there("octave-cli") {
        project("octave", prefix, &folder.join("octave"))?;
    } else {
        println!("\n== cpp: integrations/octave skipped: octave and octave-dev are not installed");
    }
    let mut signatures = Command::new("python3");
    signatures.arg("-B").arg(root().join("integrations/julia/check_signatures.py"));
    step("cpp: integrations/julia: signatures", signatures)
}

/// Configures, builds and tests a CMake project.
fn project(name: &str, prefix: &Path, build: &Path) -> Result<(), String> {
    let mut configure = cmake::configure(&root().join("integrations").join(name), build);
    configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    step(&format!("cpp: integrations/{name}: configure"), configure)?;
    step(&format!("cpp: integrations/{name}: build"), cmake::build(build))?;
    step(&format!("cpp: integrations/{name}: tests"), cmake::test(build))
}
