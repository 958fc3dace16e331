//! Says whether the library has code for vector registers of the machine it is built for: `cfg(registers)`.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(registers)");
    let machine = var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let features = var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    let has_registers = match machine.as_str() {
        "x86_64" | "aarch64" => true,
        // Nothing is looked for when a module runs: it is compiled for them, or it is not.
        "wasm32" => features.split(',').any(|feature| feature == "simd128"),
        _ => false,
    };
    if has_registers {
        println!("cargo::rustc-cfg=registers");
    }
}
