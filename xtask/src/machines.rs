//! `cargo xtask test machines`: the same tests on emulated machines, and those of `number` in an interpreter.
//!
//! Old x86-64 machines show that no code executes an instruction that the machine lacks. 64-bit ARM and
//! Node.js show that NEON and simd128 compute what the portable code does. Miri, an interpreter, checks every
//! access to memory in `number`. The emulator has no AVX-512, so it is tested only where the machine has it.

use std::process::Command;

use crate::cargo::{cargo, checked, workspace};
use crate::install::{install_package, install_target, is_there};
use crate::lab::SIMD128;
use crate::root::root;
use crate::step::step;

/// Statically linked, with Rust's own linker: no cross compiler is needed.
const ARM: &str = "aarch64-unknown-linux-musl";

/// WebAssembly with files, arguments and a clock; `wasi.mjs` runs it.
const WASI: &str = "wasm32-wasip1";

/// The tests for every machine: those of `number`, and every number and instruction set against the Lagrange
/// recipe. This machine reuses the binary of the test run; for another target nothing else is compiled.
const NUMBERS: [&str; 3] = ["--package", "robot-dynamics-number", "--lib"];
const RECURSIONS: [&str; 2] = ["--test", "any_machine"];

/// Both tests for another target.
const ELSEWHERE: [&[&str]; 2] =
    [&NUMBERS, &["--package", "robot-dynamics-tests", RECURSIONS[0], RECURSIONS[1]]];

/// Tests of machine code in memory: the bits of random graphs, kernels through their public interface, and
/// kernels in a forked process.
const NATIVE: [&str; 8] =
    ["--package", "robot-dynamics-native", "--test", "fuzz", "--test", "kernel", "--test", "fork"];

/// Tests of machine code for every function of random robots, and the variable that limits them to a few.
const BITS: [&str; 4] = ["--test", "bits", "--", "random_robots"];
const FEW: (&str, &str) = ("NATIVE_BITS", "few");

/// Whether this is the kind of machine from which the others are emulated.
const CAN_EMULATE: bool = cfg!(all(target_os = "linux", target_arch = "x86_64"));

/// Runs the tests on every machine, and `number` in the interpreter.
pub(crate) fn run() -> Result<(), String> {
    emulate()?;
    interpret()
}

/// The tests on every machine.
pub(crate) fn emulate() -> Result<(), String> {
    if !CAN_EMULATE {
        println!("\n== machines: skipped, as they are emulated on x86-64 Linux alone");
        return Ok(());
    }
    install_emulator()?;
    // The oldest has neither AVX nor FMA, the other has AVX2 and FMA.
    for processor in ["Nehalem", "Haswell"] {
        let mut numbers = checked(&["test", "--locked"]);
        numbers.args(NUMBERS);
        let mut recursions = workspace("test");
        recursions.args(RECURSIONS);
        let mut native = checked(&["test", "--locked"]);
        native.args(NATIVE);
        for mut test in [numbers, recursions, native] {
            test.env("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER", format!("qemu-x86_64 -cpu {processor}"));
            step(&format!("machines: {processor}"), test)?;
        }
    }
    // The other processor has no instructions that machine code is made of.
    let mut bits = workspace("test");
    bits.args(BITS).env(FEW.0, FEW.1);
    bits.env("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER", "qemu-x86_64 -cpu Haswell");
    step("machines: robots in machine code", bits)?;
    microcontroller()?;
    install_target(ARM)?;
    // LLVM's older choice of instructions, which takes three quarters of the time.
    let flags = "-C llvm-args=-aarch64-enable-global-isel-at-O=-1";
    let of_functions = [&["--package", "robot-dynamics-functions"], &BITS[..]].concat();
    for tests in ELSEWHERE.into_iter().chain([&NATIVE[..], &of_functions]) {
        let mut test = unoptimised(ARM, tests);
        test.env(FEW.0, FEW.1);
        test.env("RUSTFLAGS", flags);
        test.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER", "rust-lld");
        test.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER", "qemu-aarch64");
        step("machines: 64-bit ARM", test)?;
    }
    encodings()?;
    in_node()
}

/// Encodings of 64-bit ARM against those of LLVM's assembler.
fn encodings() -> Result<(), String> {
    if !is_there("llvm-mc") {
        install_package("machines", "llvm")?;
    }
    let mut test = checked(&["test", "--locked", "--package", "robot-dynamics-native", "--lib"]);
    test.arg("arm");
    step("machines: encodings of 64-bit ARM", test)
}

/// Unoptimised tests for another target: they run for seconds, and optimised they would compile for minutes.
fn unoptimised(target: &str, tests: &[&str]) -> Command {
    let mut test = cargo(&["test", "--locked", "--target", target]);
    test.args(tests).env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
    test
}

/// Generated code without the standard library, compiled for a Cortex-M4 with its floating-point unit, and
/// run on an emulated one.
fn microcontroller() -> Result<(), String> {
    install_target("thumbv7em-none-eabihf")?;
    if !is_there("qemu-system-arm") {
        install_package("machines", "qemu-system-arm")?;
    }
    let mut test = workspace("test");
    test.args(["--test", "generated", "--", "--ignored", "microcontroller"]);
    step("machines: microcontroller", test)
}

/// Tests WebAssembly with vector registers in Node.js, as the lab's robots run in browsers that have them.
fn in_node() -> Result<(), String> {
    install_target(WASI)?;
    // A module of 20 MB that runs for seconds: its optimisation would take Node.js a minute.
    let script = root().join("xtask/wasi.mjs");
    let runner = format!("node --no-warnings --liftoff-only {}", script.display());
    // Unoptimised kernels keep every intermediate number on the stack, which has one megabyte by default. The
    // flag skips LLVM's search for irreducible loops, whose time grows with the square of a function's
    // length; only optimisation would create such loops.
    let stack = format!("-C link-arg=-zstack-size={}", 64 << 20);
    let flags = format!("{SIMD128} {stack} -C llvm-args=-wasm-disable-fix-irreducible-control-flow-pass");
    for tests in ELSEWHERE {
        let mut test = unoptimised(WASI, tests);
        test.env("CARGO_TARGET_WASM32_WASIP1_RUNNER", &runner).env("RUSTFLAGS", &flags);
        step("machines: WebAssembly", test)?;
    }
    Ok(())
}

/// Installs Debian's emulator of processors if it is missing.
fn install_emulator() -> Result<(), String> {
    if is_there("qemu-x86_64") && is_there("qemu-aarch64") {
        return Ok(());
    }
    install_package("machines", "qemu-user")
}

/// The toolchain of Miri. The date keeps its results the same on every machine. It also leaves an installed
/// nightly toolchain as it is, because an update may fail halfway and leave it broken.
const INTERPRETER: &str = "nightly-2026-10-30";

/// The numbers' tests in Miri, over AVX2 as well as portable code.
pub(crate) fn interpret() -> Result<(), String> {
    if !CAN_EMULATE {
        return Ok(());
    }
    let cargo_miri = |arguments: &[&str]| {
        let mut command = Command::new("rustup");
        command.args(["run", INTERPRETER, "cargo", "miri"]).args(arguments).current_dir(root());
        command
    };
    if !cargo_miri(&["--version"]).output().is_ok_and(|output| output.status.success()) {
        let mut install = Command::new("rustup");
        install.args(["toolchain", "install", INTERPRETER, "--profile", "minimal"]);
        install.args(["--component", "miri,rust-src", "--no-self-update"]);
        step("machines: Miri", install)?;
    }
    let mut test = cargo_miri(&["test", "--locked", "--package", "robot-dynamics-number", "--lib"]);
    test.env("RUSTFLAGS", "-C target-feature=+avx2,+fma");
    // Without these flags the interpreter has no clock, and varies the last digits of sines.
    test.env("MIRIFLAGS", "-Zmiri-disable-isolation -Zmiri-deterministic-floats");
    step("machines: interpreted", test)
}
