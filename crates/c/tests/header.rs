//! The header is what cbindgen writes from the crate.

use std::path::Path;

/// The text of the header.
fn generated() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("a configuration");
    let bindings =
        cbindgen::Builder::new().with_crate(folder).with_config(config).generate().expect("a header");
    let mut text = Vec::new();
    bindings.write(&mut text);
    // Brackets of units are escaped for rustdoc.
    String::from_utf8(text).expect("UTF-8").replace("\\[", "[").replace("\\]", "]")
}

#[test]
fn header_is_generated_from_this_crate() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cpp/include/robot_dynamics.h");
    let text = generated();
    if std::env::var_os("WRITE_HEADER").is_some() {
        std::fs::write(&path, &text).expect("writes the header");
    }
    let header = std::fs::read_to_string(&path).expect("the header");
    assert!(header == text, "run `WRITE_HEADER=1 cargo test --package robot-dynamics-c --test header`");
}

#[test]
fn version_is_that_of_the_package() {
    let number = |name| std::env::var(name).expect("set by Cargo").parse::<u32>().expect("a number");
    let [major, minor, patch] =
        ["CARGO_PKG_VERSION_MAJOR", "CARGO_PKG_VERSION_MINOR", "CARGO_PKG_VERSION_PATCH"].map(number);
    assert_eq!(robot_dynamics_c::calls::RD_VERSION, 10_000 * major + 100 * minor + patch);
}
