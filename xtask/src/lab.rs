//! `cargo xtask lab`: the page of experiments, from a fresh clone to an address in the browser.

use std::path::Path;
use std::process::Command;

use crate::cargo::{UNNOTED, cargo, target_folder};
use crate::install::{install_package, install_target, is_there};
use crate::root::root;
use crate::step::step;

const TARGET: &str = "wasm32-unknown-unknown";

/// The tasks of `cargo xtask lab`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Job {
    /// Build and serve; runs until it is stopped.
    Serve,
    /// Write the static site and the single file.
    Build,
    /// Build, then run the checks that need no browser: types, lint, unit tests, native against WebAssembly.
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

/// Runs the checks that need no browser.
fn check() -> Result<(), String> {
    step("lab: types", npm(&["run", "check"]))?;
    step("lab: lint", npm(&["run", "lint"]))?;
    step("lab: unit tests, native against WebAssembly", npm(&["run", "test"]))?;
    crate::npm::test()
}

/// Tests the built page in both browsers.
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

/// The page opens with the first module. It fetches one of each pair when the user opens the map of flips or
/// a robot. The chapter computes too little to gain from vector registers.
const MODULES: [Module; 5] = [
    Module { name: "chapter", feature: "chapter", simd128: false },
    Module { name: "flips", feature: "flips", simd128: false },
    Module { name: "flips_simd128", feature: "flips", simd128: true },
    Module { name: "robots", feature: "robots", simd128: false },
    Module { name: "robots_simd128", feature: "robots", simd128: true },
];

/// The compiler flag for WebAssembly's vector registers.
pub(crate) const SIMD128: &str = "-C target-feature=+simd128";

/// Compiles crates/wasm to WebAssembly and writes modules with their types to lab/wasm. npm installs its
/// packages at the same time.
///
/// Link-time optimisation of a module keeps one processor busy. Modules with and without vector registers are
/// therefore built side by side, in separate target folders.
fn build_modules() -> Result<(), String> {
    build(&MODULES)
}

/// The same for the modules of the robots alone, which are also those of the npm package.
pub(crate) fn build_robots() -> Result<(), String> {
    build(&MODULES[3..])
}

fn build(modules: &[Module]) -> Result<(), String> {
    install_target(TARGET)?;
    let built = |simd128| modules.iter().filter(|one| one.simd128 == simd128).try_for_each(build_module);
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
    // The page computes single states and loses no speed by this flag: browsers compile the module again.
    let mut flags = UNNOTED.to_string();
    if simd128 {
        folder.push("simd128");
        flags = format!("{SIMD128} {UNNOTED}");
    }
    build.env("RUSTFLAGS", flags).arg("--target-dir").arg(&folder);
    step(&format!("lab: physics of the {name}"), build)?;
    let mut bind = cargo(&["run", "--locked", "--package", "lab-builder", "--profile", "builder", "--"]);
    bind.arg(folder.join(TARGET).join("lab/wasm.wasm")).arg(root().join("lab/wasm")).arg(name);
    step(&format!("lab: bindings of the {name}"), bind)
}

/// Runs `npm ci`, unless the installed packages are newer than the lock file.
fn install_packages() -> Result<(), String> {
    let lab = root().join("lab");
    let written = |path: &str| lab.join(path).metadata().and_then(|data| data.modified()).ok();
    if written("node_modules/.package-lock.json") >= written("package-lock.json") {
        return Ok(());
    }
    step("lab: packages", npm(&["ci", "--no-audit", "--no-fund"]))
}

/// Installs Debian's browsers, where they are missing.
pub(crate) fn install_browsers() -> Result<(), String> {
    // Chromium's engine without a window draws and computes the same, with a third less processor time.
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
    command.args(arguments).current_dir(root().join("lab"));
    command
}

fn shown(path: &str) -> String {
    root().join(path).display().to_string()
}
