//! `cargo xtask test cpp`: the C and C++ libraries, as their users build, install and find them, and the
//! integrations with ROS 2, Octave and Julia.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cargo::target_folder;
use crate::cmake;
use crate::install::{install_package, is_there};
use crate::integrations;
use crate::root::root;
use crate::step::step;
use crate::versions::workspace_version;

/// Debian packages, and a file by which each is found.
const PACKAGES: [(&str, &str); 2] =
    [("doctest-dev", "/usr/include/doctest/doctest.h"), ("libeigen3-dev", "/usr/include/eigen3/Eigen/Core")];

/// The version of the shared library's symbols.
const SYMBOL_VERSION: &str = "@@RD_0";

/// Builds, tests, installs, and builds the examples against the installation.
pub(crate) fn run() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        println!("\n== cpp: skipped, as its tools are installed on Linux alone");
        return Ok(());
    }
    install()?;
    let folder = target_folder().join("cpp");
    let (build, prefix, users) = (folder.join("build"), folder.join("prefix"), folder.join("examples"));
    let mut configure = configured("cpp", &build);
    configure.args(["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_INSTALL_LIBDIR=lib"]);
    step("cpp: configure", configure)?;
    step("cpp: build", cmake::build(&build))?;
    step("cpp: tests", cmake::test(&build))?;
    check_symbols(&build)?;
    sanitize(&folder.join("sanitized"))?;
    step("cpp: install", cmake::install(&build, &prefix))?;
    let mut find = cmake::configure(&root().join("cpp/examples"), &users);
    find.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    step("cpp: find the installed package", find)?;
    step("cpp: build the examples", cmake::build(&users))?;
    let mut example = Command::new(users.join("hold"));
    example.arg(root().join("robots/panda.urdf"));
    step("cpp: an example", example)?;
    by_pkg_config(&prefix, &folder.join("hold_c"))?;
    by_fetch_content(&folder.join("fetch_content"))?;
    integrations::run(&prefix, &folder)
}

/// Builds a project that takes the sources by FetchContent and links statically, and runs it.
fn by_fetch_content(folder: &Path) -> Result<(), String> {
    let mut configure = configured("cpp/tests/fetch_content", folder);
    configure.arg(format!("-DSOURCES={}", root().display()));
    step("cpp: configure with FetchContent", configure)?;
    let mut build = cmake::build(folder);
    build.args(["--target", "hold"]);
    step("cpp: build with FetchContent", build)?;
    let mut run = Command::new(folder.join("hold"));
    run.arg(root().join("robots/panda.urdf"));
    step("cpp: run it", run)
}

/// Configures a project that compiles the library in Cargo's usual folder.
fn configured(source: &str, build: &Path) -> Command {
    let mut command = cmake::configure(&root().join(source), build);
    command.arg(format!("-DROBOT_DYNAMICS_TARGET_DIR={}", target_folder().display()));
    command
}

/// Installs the programs that build the libraries.
fn install_compilers() -> Result<(), String> {
    for package in ["cmake", "g++"] {
        if !is_there(package) {
            install_package("cpp", package)?;
        }
    }
    Ok(())
}

/// Installs the programs and the headers of the tests.
fn install() -> Result<(), String> {
    install_compilers()?;
    if !is_there("pkg-config") {
        install_package("cpp", "pkg-config")?;
    }
    for (package, file) in PACKAGES {
        if !Path::new(file).exists() {
            install_package("cpp", package)?;
        }
    }
    Ok(())
}

/// Runs the tests with the sanitizers of addresses, leaks and undefined behaviour in C and C++. The library's
/// own allocations pass through the same checks; its code is not instrumented.
fn sanitize(folder: &Path) -> Result<(), String> {
    let sanitizers = "-fsanitize=address,undefined -fno-sanitize-recover=undefined";
    let mut configure = configured("cpp", folder);
    configure.args(["-DCMAKE_BUILD_TYPE=Debug", "-DROBOT_DYNAMICS_INSTALL=OFF"]);
    for language in ["C", "CXX"] {
        configure.arg(format!("-DCMAKE_{language}_FLAGS={sanitizers}"));
    }
    step("cpp: configure with sanitizers", configure)?;
    step("cpp: build with sanitizers", cmake::build(folder))?;
    step("cpp: tests with sanitizers", cmake::test(folder))
}

/// Builds the libraries for this machine and writes an archive of the installation into the folder.
pub(crate) fn package(folder: &Path) -> Result<Vec<PathBuf>, String> {
    // Where a release is built, Debian's packages may need a password.
    install_compilers()?;
    let build = target_folder().join("cpp/release");
    let name = format!("robot-dynamics-cpp-{}-{}-linux", workspace_version()?, std::env::consts::ARCH);
    let mut configure = configured("cpp", &build);
    configure.args([
        "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_INSTALL_LIBDIR=lib",
        "-DROBOT_DYNAMICS_TESTS=OFF",
    ]);
    step("release: configure the C++ library", configure)?;
    step("release: build the C++ library", cmake::build(&build))?;
    step("release: install it", cmake::install(&build, &folder.join(&name)))?;
    let archive = folder.join(format!("{name}.tgz"));
    let mut tar = Command::new("tar");
    tar.args(["--create", "--gzip", "--file"]).arg(&archive);
    tar.args(["--owner=0", "--group=0", "--numeric-owner", "--directory"]).arg(folder).arg(&name);
    step(&format!("release: archive {name}"), tar)?;
    fs::remove_dir_all(folder.join(&name)).map_err(|error| error.to_string())?;
    Ok(vec![archive])
}

/// Compiles the C example by the flags of pkg-config, with the static library, and runs it.
fn by_pkg_config(prefix: &Path, program: &PathBuf) -> Result<(), String> {
    let mut ask = Command::new("pkg-config");
    ask.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")).args(["--cflags", "--libs", "robot_dynamics"]);
    let flags = output(ask)?;
    let mut compile = Command::new("cc");
    compile.arg(root().join("cpp/examples/hold.c")).args(flags.split_whitespace()).arg("-o").arg(program);
    step("cpp: compile by pkg-config", compile)?;
    let mut run = Command::new(program);
    run.env("LD_LIBRARY_PATH", prefix.join("lib")).arg(root().join("robots/panda.urdf"));
    step("cpp: run it", run)
}

/// Checks that the shared library exports the functions of the header, all of one version, and nothing else.
fn check_symbols(build: &Path) -> Result<(), String> {
    println!("\n== cpp: symbols");
    let mut list = Command::new("nm");
    list.args(["--dynamic", "--defined-only"]).arg(build.join("librobot_dynamics.so"));
    let exported: BTreeSet<String> = output(list)?
        .lines()
        .filter_map(|line| line.split_whitespace().nth(2))
        .filter(|name| !name.starts_with("RD_0"))
        .map(str::to_owned)
        .collect();
    let header =
        fs::read_to_string(root().join("cpp/include/robot_dynamics.h")).map_err(|e| e.to_string())?;
    let declared: BTreeSet<String> =
        declared_functions(&header).map(|name| format!("{name}{SYMBOL_VERSION}")).collect();
    let list = |names: Vec<&String>| names.into_iter().cloned().collect::<Vec<_>>().join(", ");
    let missing = list(declared.difference(&exported).collect());
    let extra = list(exported.difference(&declared).collect());
    if missing.is_empty() && extra.is_empty() {
        println!("{} functions, each with the version {SYMBOL_VERSION}", exported.len());
        return Ok(());
    }
    Err(format!("symbols of the shared library: missing [{missing}], not in the header [{extra}]"))
}

/// The names of the functions of a header: `rd_…(` at the start of a declaration.
fn declared_functions(header: &str) -> impl Iterator<Item = &str> {
    header.lines().filter(|line| !line.starts_with([' ', '*', '/', '#'])).filter_map(|line| {
        let name = line.split('(').next()?.rsplit([' ', '*']).next()?;
        (line.contains('(') && name.starts_with("rd_")).then_some(name)
    })
}

fn output(mut command: Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::declared_functions;

    #[test]
    fn declarations_of_functions_are_found() {
        let header = "/* rd_no(x) */\nrd_status rd_one(rd_model model,\n                 size_t n);\nconst char *rd_two(void);\n";
        assert!(declared_functions(header).eq(["rd_one", "rd_two"]));
    }
}
