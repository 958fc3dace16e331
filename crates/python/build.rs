//! Sets the linker's arguments for a Python module, whose symbols macOS resolves when it is loaded. Copies
//! the robots of the package to where the compiler finds them.

use std::path::PathBuf;

const ROBOTS: [&str; 6] =
    ["two_r.urdf", "ur5.urdf", "panda.urdf", "quadruped.urdf", "humanoid.urdf", "gripper_and_box.xml"];

fn main() -> std::io::Result<()> {
    pyo3_build_config::add_extension_module_link_args();
    let folder = |name| PathBuf::from(std::env::var_os(name).unwrap_or_default());
    let (own, out) = (folder("CARGO_MANIFEST_DIR"), folder("OUT_DIR"));
    for file in ROBOTS {
        // In the repository; or, in a source distribution, what the links in this folder have become there.
        // (A checkout without links, on Windows, has files with their text instead.)
        let repository = own.join("../../robots").join(file);
        let source = if repository.is_file() { repository } else { own.join("robots").join(file) };
        println!("cargo::rerun-if-changed={}", source.display());
        std::fs::write(out.join(file), std::fs::read(source)?)?;
    }
    Ok(())
}
