//! Project chores: `cargo xtask test` runs every check, `cargo xtask tidy` the checks on the tree's own rules.
//!
//! Standard library only, so that the first command of a fresh clone compiles in seconds.

mod examples;
mod gpu;
mod install;
mod lab;
mod machines;
mod packaged;
mod python;
mod rooms;
mod site;
mod step;
mod tidy;

use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicUsize, Ordering};

use step::step;

const USAGE: &str = "usage: cargo xtask <command>

  test    what must pass before a change lands: format, lints, tests, doc tests, example, documentation, the lab
  test PART…  only these parts of it: style (format, tree, lints), rust (tests, doc tests, example, a user's
          program), docs, guide (the site without the lab and the Rust reference; no dead link),
          gpu (batches on a device, Mesa's on the processor where there is no other; part of rust, too, where
          there is one), machines (emulated processors, and the numbers interpreted), python (the package, by
          pip), lab
  tidy    only the checks on the tree's own rules (layering, rooms, file sizes, examples)
  rooms   writes the graph of multibody's rooms into ARCHITECTURE.md
  lab     builds the page of experiments and serves it; --build only writes it, --test checks it in a browser
  site    builds the lab, the guide and the references as one static site; --serve serves it";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["test"] => everything(),
        ["test", parts @ ..] => test(parts),
        ["tidy"] => tidy::check(),
        ["rooms"] => rooms::write(),
        ["lab"] => lab::run(lab::Job::Serve),
        ["lab", "--build"] => lab::run(lab::Job::Build),
        ["lab", "--test"] => lab::run(lab::Job::Test),
        ["site"] => site::run(site::Job::Build),
        ["site", "--serve"] => site::run(site::Job::Serve),
        _ => Err(USAGE.into()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The parts of the test run, in the order of what fails fastest.
const PARTS: [&str; 8] = ["style", "rust", "docs", "guide", "gpu", "machines", "python", "lab"];

/// A part of the checks, or some of one.
type Check = fn() -> Result<(), String>;

/// What runs beside the other parts: Python's tests, emulators; and all of the lab but browsers. Each keeps one core busy, or two now and then.
const BESIDE: [Check; 5] = [
    python::run,
    machines::emulate,
    || lab::run(lab::Job::Check),
    machines::interpret,
    lab::install_browsers,
];

/// How many of these have been begun.
static BEGUN: AtomicUsize = AtomicUsize::new(0);

/// Runs all parts on two threads, of which whoever is done with its own takes what is left; the browsers alone, as what they show depends on how
/// fast the machine is. The tests on a device are among the rest where there is one.
fn everything() -> Result<(), String> {
    let beside = step::beside(|| {
        // First, as Python's package has most of what it depends on; whoever runs it afterwards need not wait.
        step("the first command", cargo(&["build", "--release", "--locked"]))?;
        help()
    });
    let ours = step::noted(gpu::install_driver().and_then(|()| {
        let is_ours = |name: &&&str| !["python", "machines", "lab", "gpu"].contains(name);
        PARTS.iter().filter(is_ours).try_for_each(|name| part(name))?;
        help()
    }));
    let theirs = beside.join().unwrap_or_else(|_| Err("what ran beside the rest panicked".into()));
    match (ours, theirs) {
        (Ok(()), Ok(())) => lab::in_browsers()?,
        (Err(one), Err(other)) => return Err(format!("{one}\n{other}")),
        (Err(one), Ok(())) | (Ok(()), Err(one)) => return Err(one),
    }
    println!("\nall checks passed");
    Ok(())
}

/// Runs what no other thread has begun.
fn help() -> Result<(), String> {
    while let Some(check) = BESIDE.get(BEGUN.fetch_add(1, Ordering::Relaxed)) {
        check()?;
    }
    Ok(())
}

/// Runs these parts of the checks.
fn test(parts: &[&str]) -> Result<(), String> {
    if let Some(unknown) = parts.iter().find(|part| !PARTS.contains(part)) {
        return Err(format!(
            "there is no part `{unknown}` of the test run; the parts are {}",
            PARTS.join(", ")
        ));
    }
    PARTS.iter().filter(|name| parts.contains(name)).try_for_each(|name| part(name))?;
    println!("\n{} passed", parts.join(", "));
    Ok(())
}

/// Runs one part.
fn part(name: &str) -> Result<(), String> {
    match name {
        "style" => style(),
        "rust" => rust(),
        "docs" => docs(),
        "guide" => site::run(site::Job::Guide),
        "gpu" => gpu::run(),
        "machines" => machines::run(),
        "python" => python::run(),
        _ => {
            println!("\n== lab");
            lab::run(lab::Job::Test)
        }
    }
}

fn style() -> Result<(), String> {
    step("format", cargo(&["fmt", "--all", "--check"]))?;
    step("format of a user's program", cargo(&["fmt", "--manifest-path", DOWNSTREAM, "--check"]))?;
    // Cargo rewrites it without a word, wherever `--locked` is not given.
    step("lock file of a user's program", cargo(&["fetch", "--locked", "--manifest-path", DOWNSTREAM]))?;
    println!("\n== tidy");
    tidy::check()?;
    step(
        "lints",
        checked(&[
            "clippy",
            "--workspace",
            "--all-targets",
            "--all-features",
            "--locked",
            "--",
            "-D",
            "warnings",
        ]),
    )?;
    // As the first command of the README and a program without features build them.
    step(
        "lints without features",
        checked(&["clippy", "--package", "robot-dynamics-cli", "--locked", "--", "-D", "warnings"]),
    )?;
    step(
        "lints of the bare library",
        checked(&["clippy", "--package", "robot-dynamics", "--locked", "--", "-D", "warnings"]),
    )
}

fn rust() -> Result<(), String> {
    install_clang();
    step("tests and doc tests", gpu::expecting_a_device(workspace("test")))?;
    example("two_r_numbers")?;
    example("rollout")?;
    let mut downstream = cargo(&["run", "--locked", "--manifest-path", DOWNSTREAM]);
    downstream.env("CARGO_TARGET_DIR", target_folder().join("downstream"));
    step("a user's program", downstream)
}

/// A cargo command for all of our crates with all their features. Whatever is compiled so is compiled once: for a package alone
/// what it depends on has fewer features, and is another. What builds the lab has no tests.
fn workspace(command: &str) -> Command {
    checked(&[command, "--workspace", "--exclude", "lab-builder", "--all-features", "--locked"])
}

/// Runs an example that the test run has compiled.
fn example(name: &str) -> Result<(), String> {
    let file = format!("debug/examples/{name}{}", std::env::consts::EXE_SUFFIX);
    step(&format!("example {name}"), gpu::expecting_a_device(Command::new(target_folder().join(file))))
}

/// Generated C is compiled by Clang too, where it is; the tests pass over it elsewhere.
fn install_clang() {
    if install::is_there("clang") || !install::is_there("apt-get") {
        return;
    }
    if let Err(cause) = install::install_package("rust", "clang") {
        println!("== rust: generated C is not compiled by Clang: {cause}");
    }
}

/// A program with a workspace of its own, as a stranger builds it.
const DOWNSTREAM: &str = "testdata/downstream/Cargo.toml";

fn docs() -> Result<(), String> {
    let mut docs = checked(&["doc", "--workspace", "--all-features", "--no-deps", "--locked"]);
    // With the examples what is depended on has the features that tests ask for, and was checked for the lints.
    docs.args(["--lib", "--bins", "--examples"]).env("RUSTDOCFLAGS", "-D warnings");
    step("documentation", docs)
}

/// Where cargo builds.
fn target_folder() -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    tidy::root().join(folder)
}

/// Which references cannot meet is not noted wherever LLVM inlines a function: that takes a fifth of compiling the recursions.
const UNNOTED: &str = "-C llvm-args=-enable-noalias-to-md-conversion=false";

/// A cargo command whose programs are tested, not timed. Lints and documentation share with the tests what runs in the compiler, and its flags.
fn checked(arguments: &[&str]) -> Command {
    let mut command = cargo(arguments);
    let theirs = std::env::var("RUSTFLAGS").unwrap_or_default();
    command.env("RUSTFLAGS", format!("{theirs} {UNNOTED}").trim_start());
    command
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(tidy::root());
    command
}
