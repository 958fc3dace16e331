//! `cargo xtask release --dry-run`: every file of a release that this machine can make, with its size and the
//! place where `.github/workflows/release.yml` publishes it. Nothing is published.

mod command;
mod crates;
mod wheels;

use std::fs;
use std::path::{Path, PathBuf};

use crate::cargo::target_folder;
use crate::{cpp, lab, npm};

/// Where files are published.
const CRATES_IO: &str = "crates.io";
const PYPI: &str = "PyPI";
const NPM: &str = "npm";
const FORGE: &str = "page of the release";

/// Settings of Cargo that make smaller files. The crates that trace robots are a third of a wheel without
/// optimisation, which the profile `release` leaves out since it takes minutes.
const SMALL: [&str; 4] = [
    "--config",
    "profile.release.package.robot-dynamics-functions.opt-level=\"s\"",
    "--config",
    "profile.release.package.robot-dynamics-generate.opt-level=\"s\"",
];

/// Files that only the workflow makes, since they need another system or another Python.
const ELSEWHERE: [(&str, &str); 6] = [
    ("wheel, macOS, both processors", PYPI),
    ("wheel, Windows, x86-64", PYPI),
    ("wheels, free-threaded Python 3.14, each system", PYPI),
    ("command, macOS, ARM", FORGE),
    ("command, macOS, x86-64", FORGE),
    ("command, Windows, x86-64", FORGE),
];

/// A part of the release: its maker and its destination.
type Part = (&'static str, fn(&Path) -> Result<Vec<PathBuf>, String>, &'static str);

const PARTS: [Part; 5] = [
    ("command", command::make, FORGE),
    ("cpp", cpp::package, FORGE),
    ("wheels", wheels::make, PYPI),
    ("npm", package, NPM),
    ("crates", crates::make, CRATES_IO),
];

/// Makes the parts with these names, or all of them, and prints the table.
pub(crate) fn dry_run(names: &[&str]) -> Result<(), String> {
    if let Some(unknown) = names.iter().find(|name| PARTS.iter().all(|part| part.0 != **name)) {
        let known = PARTS.map(|part| part.0).join(", ");
        return Err(format!("there is no part `{unknown}` of a release; the parts are {known}"));
    }
    let folder = target_folder().join("release-packages");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut rows = Vec::new();
    for (name, make, destination) in PARTS {
        if !names.is_empty() && !names.contains(&name) {
            continue;
        }
        for file in make(&folder)? {
            let length = fs::metadata(&file).map_err(|error| format!("{}: {error}", file.display()))?.len();
            let shown = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            rows.push((shown, size(length), destination));
        }
    }
    let others =
        ELSEWHERE.iter().map(|&(what, destination)| (what.to_owned(), "workflow".into(), destination));
    rows.extend(others);
    print_table(&rows);
    println!("\nfiles: {}", folder.display());
    Ok(())
}

fn package(folder: &Path) -> Result<Vec<PathBuf>, String> {
    lab::build_robots()?;
    npm::test()?;
    npm::pack(folder)?;
    with_ending(folder, ".tgz", "robot-dynamics-wasm-")
}

/// The files of a folder with that ending and beginning, in order.
fn with_ending(folder: &Path, ending: &str, beginning: &str) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let is_one = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(beginning) && name.ends_with(ending)
    };
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_one).collect();
    found.sort();
    Ok(found)
}

/// A size in kB or MB.
fn size(bytes: u64) -> String {
    let kilobytes = bytes.div_ceil(1000);
    if kilobytes < 1000 {
        format!("{kilobytes} kB")
    } else {
        format!("{}.{} MB", kilobytes / 1000, kilobytes % 1000 / 100)
    }
}

fn print_table(rows: &[(String, String, &str)]) {
    let header = ("file".to_owned(), "size".to_owned(), "published on");
    let rows: Vec<_> = std::iter::once(&header).chain(rows).collect();
    let wide = |column: fn(&(String, String, &str)) -> usize| rows.iter().map(|row| column(row)).max();
    let (first, second) = (wide(|row| row.0.chars().count()), wide(|row| row.1.chars().count()));
    let (first, second) = (first.unwrap_or(0), second.unwrap_or(0));
    println!();
    for (name, size, destination) in rows {
        println!("{name:first$}  {size:>second$}  {destination}");
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_two_or_three_digits() {
        assert_eq!([1, 999_000, 1_250_000].map(size), ["1 kB", "999 kB", "1.2 MB"]);
    }
}
