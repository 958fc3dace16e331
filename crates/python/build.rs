//! The linker's arguments for a module of Python: on macOS its names are found when it is loaded.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
