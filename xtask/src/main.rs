//! Project chores: `cargo xtask test` runs every check, `cargo xtask tidy` the checks on the tree's own
//! rules.
//!
//! It uses the standard library alone, so that the first command of a fresh clone compiles in seconds.

mod allowances;
mod cargo;
mod cmake;
mod cpp;
mod examples;
mod files;
mod gpu;
mod graph;
mod install;
mod integrations;
mod lab;
mod layers;
mod lexer;
mod machines;
mod manifest;
mod measure;
mod modules;
mod npm;
mod packages;
mod prose;
mod python;
mod release;
mod root;
mod semver;
mod sentences;
mod site;
mod spelling;
mod step;
mod text_blocks;
mod tidy;
mod tokens;
mod versions;
mod wrap;

use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use cargo::{cargo, checked, target_folder, workspace};
use step::step;
use tidy::Allowances;

const USAGE: &str = "usage: cargo xtask <command>

  test    what must pass before a change lands: format, lints, tests, doc tests, example, documentation, the lab
  test PART…  only these parts of it: style (format, tree, lints), rust (tests, doc tests, example, a user's
          program), docs, guide (the site without the lab and the Rust reference; no dead link),
          gpu (batches on a device, Mesa's on the processor where there is no other; part of rust, too, where
          there is one), machines (emulated processors, and the numbers interpreted), python (the package, by
          pip), cpp (the C and C++ libraries, by CMake), lab
  tidy    only the checks on the tree's own rules (layering, cycles, file sizes, examples, prose);
          --write-allowances lowers the counts in xtask/allowances.txt, with --force it raises them too
  graph   writes the graphs of crates and modules into ARCHITECTURE.md
  measure prints sizes, names, cycles, prose and duplicates as a table; --json FILE writes them, too;
          --tree FOLDER measures another checkout
  cycles [PATH] lists the cycles between files below a path, with every name that they use of each other
  prose PATH…  lists the places in these files and folders that break a rule of prose
  wrap PATH…   wraps paragraphs of comments and Markdown in them that have a line wider than 110 columns
  spell   checks the spelling of the tree; part of style, too
  semver  compares the public API with the last release; installs cargo-semver-checks where it is missing
  lab     builds the page of experiments and serves it; --build only writes it, --test checks it in a browser
  npm     builds the npm package and tests it in Node.js; part of lab, too
  release --dry-run [PART…] makes the files of a release, without publishing them: command (static binaries,
          Debian packages), cpp, wheels, npm, crates
  site    builds the lab, the guide and the references as one static site; --serve serves it";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["test"] => everything(),
        ["test", parts @ ..] => test(parts),
        ["tidy"] => tidy::check(Allowances::Compare),
        ["tidy", "--write-allowances"] => tidy::check(Allowances::Lower),
        ["tidy", "--write-allowances", "--force"] => tidy::check(Allowances::Replace),
        ["graph"] => graph::write(),
        ["measure", options @ ..] => measure::run(options),
        ["cycles"] => graph::list_cycles(""),
        ["cycles", below] => graph::list_cycles(below),
        ["prose", paths @ ..] if !paths.is_empty() => tidy::list_prose(paths),
        ["wrap", paths @ ..] if !paths.is_empty() => wrap::run(paths),
        ["spell"] => spelling::run(),
        ["semver"] => semver::run(),
        ["lab"] => lab::run(lab::Job::Serve),
        ["lab", "--build"] => lab::run(lab::Job::Build),
        ["lab", "--test"] => lab::run(lab::Job::Test),
        ["release", "--dry-run", parts @ ..] => release::dry_run(parts),
        ["npm"] => npm::run(),
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

/// The parts of the test run, those that fail fastest first.
const PARTS: [&str; 9] = ["style", "rust", "docs", "guide", "gpu", "machines", "python", "cpp", "lab"];

/// A part of the checks, or some of one.
type Check = fn() -> Result<(), String>;

/// The checks that run beside the other parts: Python's tests, emulators, and the lab without browsers. Each
/// keeps one core busy, sometimes two.
const BESIDE: [Check; 6] = [
    python::run,
    cpp::run,
    machines::emulate,
    || lab::run(lab::Job::Check),
    machines::interpret,
    lab::install_browsers,
];

/// How many of these have started.
static BEGUN: AtomicUsize = AtomicUsize::new(0);

/// Runs all parts on two threads. A thread that has finished its own checks takes the next of `BESIDE`. The
/// browsers run alone, as their tests depend on the machine's speed. Tests on a device are part of `rust`.
fn everything() -> Result<(), String> {
    let beside = step::beside(|| {
        // This build comes first, as the Python package shares most of its dependencies.
        step("the first command", cargo(&["build", "--release", "--locked"]))?;
        help()
    });
    let ours = step::noted(gpu::install_driver().and_then(|()| {
        let is_ours = |name: &&&str| !["python", "cpp", "machines", "lab", "gpu"].contains(name);
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

/// Runs the checks of `BESIDE` that no thread has started.
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
        "cpp" => cpp::run(),
        _ => {
            println!("\n== lab");
            lab::run(lab::Job::Test)
        }
    }
}

fn style() -> Result<(), String> {
    step("format", cargo(&["fmt", "--all", "--check"]))?;
    step("format of a user's program", cargo(&["fmt", "--manifest-path", DOWNSTREAM, "--check"]))?;
    // Cargo rewrites it silently, wherever `--locked` is not given.
    step("lock file of a user's program", cargo(&["fetch", "--locked", "--manifest-path", DOWNSTREAM]))?;
    println!("\n== tidy");
    tidy::check(Allowances::Compare)?;
    spelling::run()?;
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
    gpu::example("two_r_numbers")?;
    gpu::example("rollout")?;
    let mut downstream = cargo(&["run", "--locked", "--manifest-path", DOWNSTREAM]);
    downstream.env("CARGO_TARGET_DIR", target_folder().join("downstream"));
    step("a user's program", downstream)
}

/// Installs Clang, which also compiles generated C. Without it the tests skip that.
fn install_clang() {
    if install::is_there("clang") || !install::is_there("apt-get") {
        return;
    }
    if let Err(cause) = install::install_package("rust", "clang") {
        println!("== rust: generated C is not compiled by Clang: {cause}");
    }
}

/// A user's program in a separate workspace.
const DOWNSTREAM: &str = "testdata/downstream/Cargo.toml";

fn docs() -> Result<(), String> {
    let mut docs = checked(&["doc", "--workspace", "--all-features", "--no-deps", "--locked"]);
    // With examples, dependencies have the features that tests need and that the lints have already checked.
    docs.args(["--lib", "--bins", "--examples"]).env("RUSTDOCFLAGS", "-D warnings");
    step("documentation", docs)
}
