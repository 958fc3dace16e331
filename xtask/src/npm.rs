//! The npm package `@robot-dynamics/wasm`: the lab's modules of the robots with a loader and types.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::lab;
use crate::root::root;
use crate::step::step;

/// The lab's modules that the package contains: without and with vector registers.
const MODULES: [&str; 2] = ["robots", "robots_simd128"];

/// Files of each module after its name.
const PARTS: [&str; 4] = [".js", ".d.ts", "_bg.wasm", "_bg.wasm.d.ts"];

const LICENCES: [&str; 2] = ["LICENSE-APACHE", "LICENSE-MIT"];

/// Builds the modules of the robots and tests the package.
pub(crate) fn run() -> Result<(), String> {
    lab::build_robots()?;
    test()
}

/// Installs the packed package into an empty folder and compares its numbers with closed forms. The modules
/// are in `lab/wasm`.
pub(crate) fn test() -> Result<(), String> {
    assemble()?;
    let mut test = Command::new("node");
    test.args(["--test", "test/package.test.js"]).current_dir(root().join("npm"));
    step("npm: the package in an empty folder", test)
}

/// Writes the package as a file into a folder.
pub(crate) fn pack(folder: &Path) -> Result<(), String> {
    assemble()?;
    let mut pack = Command::new("npm");
    pack.args(["pack", "--pack-destination"]).arg(folder).current_dir(root().join("npm"));
    step("npm: package", pack)
}

/// Copies the lab's modules and the licences into the package.
fn assemble() -> Result<(), String> {
    let (from, package) = (root().join("lab/wasm"), root().join("npm"));
    let module = package.join("module");
    fs::create_dir_all(&module).map_err(|error| format!("{}: {error}", module.display()))?;
    let parts = MODULES.iter().flat_map(|name| PARTS.map(|part| format!("{name}{part}")));
    let files = parts.map(|name| (from.join(&name), module.join(&name)));
    let licences = LICENCES.map(|name| (root().join(name), package.join(name)));
    for (source, target) in files.chain(licences) {
        fs::copy(&source, &target).map_err(|error| format!("{}: {error}", source.display()))?;
    }
    Ok(())
}
