//! `cargo xtask lab`: the page of experiments, from a fresh clone to an address in the browser.

use std::path::Path;
use std::process::Command;

use crate::install::{install_package, install_target, is_there};
use crate::step::step;
use crate::{UNNOTED, cargo, target_folder, tidy};

const TARGET: &str = "wasm32-unknown-unknown";

/// What `cargo xtask lab` is asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Job {
    /// Build and serve; runs until it is stopped.
    Serve,
    /// Write the static site and the single file.
    Build,
    /// Build, then what needs no browser: types, lint, unit tests, native against WebAssembly.
    Check,
    /// Every check, in browsers too.
    Test,
}

/// Builds the lab, and then serves or tests it.
pub(crate) fn run(job: Job) -> Result<(), String> {
    build_modules()?;
    step("lab: page", npm(&["run", "build"]))?;
    println!("\nstatic site:  {}", shown("lab/dist/site"));
    println!("single file:  {} (opens without a server)", shown("lab/dist/single/index.html"));
    match job {
        Job::Build => Ok(()),
        Job::Serve => {
            println!("\nopen the address below; Ctrl-C ends it");
            step("lab: serve", npm(&["run", "preview"]))
        }
        Job::Check => check(),
        Job::Test => {
            check()?;
            install_browsers()?;
            in_browsers()
        }
    }
}

/// What needs no browser.
fn check() -> Result<(), String> {
    step("lab: types", npm(&["run", "check"]))?;
    step("lab: lint", npm(&["run", "lint"]))?;
    step("lab: unit tests, native against WebAssembly", npm(&["run", "test"]))
}

/// The page as it is built, in both browsers.
pub(crate) fn in_browsers() -> Result<(), String> {
    step("lab: in Chromium", npm(&["run", "browser"]))?;
    step("lab: in Firefox", npm(&["run", "firefox"]))
}

/// A module of crates/wasm.
struct Module {
    name: &'static str,
    feature: &'static str,
    /// For browsers that have vector registers.
    simd128: bool,
}

/// The page opens with the first, and fetches one of each other pair when someone comes to the map of flips or to a robot.
/// The chapter's few numbers gain nothing by registers.
const MODULES: [Module; 5] = [
    Module { name: "chapter", feature: "chapter", simd128: false },
    Module { name: "flips", feature: "flips", simd128: false },
    Module { name: "flips_simd128", feature: "flips", simd128: true },
    Module { name: "robots", feature: "robots", simd128: false },
    Module { name: "robots_simd128", feature: "robots", simd128: true },
];

/// What the compiler is told to use vector registers of WebAssembly.
pub(crate) const SIMD128: &str = "-C target-feature=+simd128";

/// crates/wasm to WebAssembly files, and those to modules with their types in lab/wasm; meanwhile what npm brings.
///
/// The last of each module's compilation, over all crates at once, keeps one processor busy: modules with registers and without are
/// built side by side, in target folders of their own.
fn build_modules() -> Result<(), String> {
    install_target(TARGET)?;
    let built = |simd128| MODULES.iter().filter(|one| one.simd128 == simd128).try_for_each(build_module);
    std::thread::scope(|scope| {
        let beside = [scope.spawn(|| built(true)), scope.spawn(install_packages)];
        let plain = built(false);
        let others = beside.map(|one| one.join().map_err(|_| "a part of the build panicked".to_string())?);
        others.into_iter().fold(plain, Result::and)
    })
}

fn build_module(&Module { name, feature, simd128 }: &Module) -> Result<(), String> {
    let mut build = cargo(&["build", "--locked", "--package", "wasm", "--lib", "--target", TARGET]);
    build.args(["--profile", "lab", "--no-default-features", "--features", feature]);
    let mut folder = target_folder();
    // Single states, which are what the page computes, lose nothing by it: browsers compile the module once more.
    let mut flags = UNNOTED.to_string();
    if simd128 {
        folder.push("simd128");
        flags = format!("{SIMD128} {UNNOTED}");
    }
    build.env("RUSTFLAGS", flags).arg("--target-dir").arg(&folder);
    step(&format!("lab: physics of the {name}"), build)?;
    let mut bind = cargo(&["run", "--locked", "--package", "lab-builder", "--profile", "builder", "--"]);
    bind.arg(folder.join(TARGET).join("lab/wasm.wasm")).arg(tidy::root().join("lab/wasm")).arg(name);
    step(&format!("lab: bindings of the {name}"), bind)
}

/// `npm ci`, unless what is installed is what the lock file says.
fn install_packages() -> Result<(), String> {
    let lab = tidy::root().join("lab");
    let written = |path: &str| lab.join(path).metadata().and_then(|data| data.modified()).ok();
    if written("node_modules/.package-lock.json") >= written("package-lock.json") {
        return Ok(());
    }
    step("lab: packages", npm(&["ci", "--no-audit", "--no-fund"]))
}

/// Debian's browsers, where there are none.
pub(crate) fn install_browsers() -> Result<(), String> {
    // Chromium's engine without its window: what draws and computes is the same, on a third less of the processor.
    let has = |program: &str| Path::new("/usr/bin").join(program).exists();
    let does_without = has("chromium") && !is_there("apt-get");
    for (package, is_wanted) in [("chromium-headless-shell", !does_without), ("firefox-esr", true)] {
        if is_wanted && !has(package) {
            install_package("lab", package)?;
        }
    }
    Ok(())
}

fn npm(arguments: &[&str]) -> Command {
    let mut command = Command::new("npm");
    command.args(arguments).current_dir(tidy::root().join("lab"));
    command
}

fn shown(path: &str) -> String {
    tidy::root().join(path).display().to_string()
}
