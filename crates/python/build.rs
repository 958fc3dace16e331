//! The linker's arguments for a module of Python, whose names are found on macOS when it is loaded; and where the robots are that
//! come with the package.

use std::path::PathBuf;

fn main() {
    pyo3_build_config::add_extension_module_link_args();
    // In the repository; or, in a source distribution, what the links in this folder have become there. A checkout may have
    // no links but files with their text (Windows).
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let repository = own.join("../../robots");
    let robots = if repository.join("two_r.urdf").is_file() { repository } else { own.join("robots") };
    println!("cargo::rustc-env=ROBOTS={}", robots.display());
    println!("cargo::rerun-if-changed=robots");
}
