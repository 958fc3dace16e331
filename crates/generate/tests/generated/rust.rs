//! Rust, compiled by the compiler of this test.

use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, Precision, Request, Sine, Target, generate};

use crate::folder::Folder;
use crate::robots;

const EDITION: [&str; 4] = ["--edition", "2021", "-D", "warnings"];

/// Compiles and runs the generated test.
pub(crate) fn test(name: &str, model: &Model, functions: Vec<Function>, arithmetic: Arithmetic) -> String {
    let request = Request::new(Target::Rust, functions).with_arithmetic(arithmetic).with_name("robot");
    let folder = Folder::of(name, &generate(model, &request).unwrap());
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let compile = |arguments: &[&str]| folder.compile(&rustc, &[&EDITION, arguments].concat());
    compile(&["--crate-type", "rlib", "--crate-name", "robot", "src/lib.rs", "-o", "librobot.rlib"]);
    compile(&["--test", "--extern", "robot=librobot.rlib", "tests/golden.rs", "-o", "golden"]);
    folder.run("./golden", &[])
}

#[test]
fn every_function_has_the_bits_of_the_library_without_the_standard_library() {
    let model = robots::named("gripper.urdf");
    for (name, precision) in [("rust_double", Precision::Double), ("rust_single", Precision::Single)] {
        let output = test(name, &model, robots::with_derivatives(&model), Arithmetic::new(precision));
        assert!(output.contains("72 passed"), "{output}");
    }
    let code = Request::new(Target::Rust, vec![Function::Gravity]).with_name("robot");
    let root = generate(&model, &code).unwrap().file("src/lib.rs").unwrap().text.clone();
    assert!(root.contains("#![no_std]"), "{root}");
}

#[test]
fn every_arithmetic_agrees_with_the_library() {
    let model = robots::random();
    let ways = [Arithmetic::default().with_fused(), Arithmetic::default().with_sine(Sine::Platform)];
    for (name, arithmetic) in ["rust_fused", "rust_platform"].into_iter().zip(ways) {
        let output = test(name, &model, robots::functions(&model), arithmetic);
        assert!(output.contains("28 passed"), "{output}");
    }
}

/// The module can be included in any crate and module.
#[test]
fn a_module_can_be_included() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    let generated = robot_dynamics_generate::Builder::new(path).generate(Target::Rust).unwrap();
    let folder = Folder::of("rust_included", &generated);
    let program = "mod arm { include!(\"src/two_r.rs\"); }\n\
                   fn main() { let mut a = [0.0; 2]; arm::forward_dynamics(&[0.0; 2], &[0.0; 2], &[0.0; 2], &mut a); \
                   let mut m = [0.0; 4]; arm::mass_matrix(&[0.0; 2], &mut m); \
                   let mut tau = [0.0; 2]; arm::inverse_dynamics(&[0.0; 2], &[0.0; 2], &a, &mut tau); \
                   assert!(tau[0].abs() + tau[1].abs() < 1e-13 && m[1] == m[2] && arm::NQ == arm::NV); }\n";
    std::fs::write(folder.0.join("main.rs"), program).unwrap();
    folder.run("rustc", &[&EDITION[..], &["main.rs", "-o", "main"]].concat());
    folder.run("./main", &[]);
}

/// Every function, compiled for a Cortex-M4 with a floating-point unit, calls neither the allocator nor
/// floating-point arithmetic in software.
#[test]
#[ignore = "needs the target thumbv7em-none-eabihf, which `cargo xtask test machines` installs"]
fn singles_compile_for_a_microcontroller() {
    let model = robots::named("panda.urdf");
    let request = Request::new(Target::Rust, robots::functions(&model))
        .with_arithmetic(Arithmetic::new(Precision::Single))
        .with_name("robot");
    let folder = Folder::of("rust_microcontroller", &generate(&model, &request).unwrap());
    let target =
        ["--target", "thumbv7em-none-eabihf", "-O", "--crate-type", "rlib", "--emit", "asm", "src/lib.rs"];
    folder.run("rustc", &[&EDITION[..], &target].concat());
    let code = std::fs::read_to_string(folder.0.join("lib.s")).unwrap();
    assert!(code.contains("vmul.f32") && code.contains("inverse_dynamics"));
    for call in ["__aeabi_d", "__aeabi_fmul", "__aeabi_fadd", "__rust_alloc", "fmaf"] {
        assert!(!code.contains(call), "{call}");
    }
}
