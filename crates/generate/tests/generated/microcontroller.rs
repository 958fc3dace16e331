//! Generated Rust on an emulated microcontroller: QEMU runs it on a Cortex-M4 with a floating-point unit.

use std::fmt::Write;
use std::path::Path;

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, Precision, Request, Target, generate};
use serde_json::Value;

use crate::folder::Folder;
use crate::robots;

/// The text of `cases.rs`, which calls each function in states with known results of the library.
fn cases(model: &Model, functions: &[Function]) -> String {
    // The shader's golden values have the same arithmetic.
    let single = Arithmetic::new(Precision::Single);
    let request = Request::new(Target::Wgsl, functions.to_vec()).with_arithmetic(single).with_name("robot");
    let golden = generate(model, &request).unwrap().file("golden.json").unwrap().text.clone();
    let golden: Value = serde_json::from_str(&golden).unwrap();
    let mut text = String::from("fn cases() {\n");
    for function in functions {
        let values = &golden[function.symbol()];
        let table = |name: &str| -> String {
            #[allow(clippy::cast_possible_truncation)] // they are singles
            let bits = |x: &Value| format!("{:#x}", (x.as_f64().unwrap() as f32).to_bits());
            let row = |row: &Value| row.as_array().unwrap().iter().map(bits).collect::<Vec<_>>().join(", ");
            let rows: Vec<String> = values[name].as_array().unwrap().iter().map(row).collect();
            format!("[[{}]]", rows.join("], ["))
        };
        let symbol = function.symbol();
        let result = function.writes(model)[0];
        let width = result.width();
        let mut passed = String::new();
        for argument in function.reads(model) {
            let (name, width) = (argument.name, argument.width());
            let _ = writeln!(text, "    const {symbol}_{name}: [[u32; {width}]; 5] = {};", table(name));
            let _ = write!(passed, "&{symbol}_{name}[state].map(f32::from_bits), ");
        }
        let expected = table(&format!("-> {}", result.name));
        let _ = writeln!(text, "    const {symbol}_expected: [[u32; {width}]; 5] = {expected};");
        let _ = writeln!(
            text,
            "    run(\"{function}\", &{symbol}_expected, |state, out| robot::{symbol}({passed}out));"
        );
    }
    text + "}\n"
}

#[test]
#[ignore = "needs the target thumbv7em-none-eabihf and qemu-system-arm, which `cargo xtask test machines` installs"]
fn a_microcontroller_has_the_bits_of_the_library() {
    let model = robots::named("panda.urdf");
    let frame = Function::FrameJacobian(ReferenceFrame::LocalWorldAligned, "panda_link8".into());
    let functions = [Function::InverseDynamics, Function::Gravity, frame];
    let request = Request::new(Target::Rust, functions.to_vec())
        .with_arithmetic(Arithmetic::new(Precision::Single))
        .with_name("robot");
    let folder = Folder::of("microcontroller", &generate(&model, &request).unwrap());
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/generated/microcontroller");
    for file in ["main.rs", "memory.x"] {
        std::fs::copy(sources.join(file), folder.0.join(file)).unwrap();
    }
    std::fs::write(folder.0.join("cases.rs"), cases(&model, &functions)).unwrap();
    // The options of Cargo's release profile.
    folder.run(
        "rustc",
        &[
            "--edition=2024",
            "--target=thumbv7em-none-eabihf",
            "-Copt-level=3",
            "-Cpanic=abort",
            "-Clink-arg=-Tmemory.x",
            "-Anon_upper_case_globals",
            "main.rs",
        ],
    );
    // The emulator's clock advances by a nanosecond for each instruction.
    let machine = ["-machine", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"];
    let counted = ["-icount", "shift=0", "-semihosting-config", "enable=on,target=native", "-kernel", "main"];
    let output = folder.run("qemu-system-arm", &[&machine[..], &counted].concat());
    println!("{output}");
    for function in &functions {
        let bits = 5 * 32 * function.writes(&model)[0].width();
        assert!(output.contains(&format!("{function}: {bits} bits, ")), "{output}");
    }
}
