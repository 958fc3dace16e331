//! Sets `cfg(registers)` where the library has code for the vector registers of the target.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(registers)");
    let machine = var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let features = var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    let has_registers = match machine.as_str() {
        "x86_64" | "aarch64" => true,
        // A WebAssembly module cannot detect instructions at run time, so the target features decide.
        "wasm32" => features.split(',').any(|feature| feature == "simd128"),
        _ => false,
    };
    if has_registers {
        println!("cargo::rustc-cfg=registers");
    }
}
