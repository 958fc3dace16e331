//! The packages of the published crates, each built from its package.

use std::fs;
use std::path::{Path, PathBuf};

use crate::cargo::{cargo, target_folder};
use crate::layers::libraries;
use crate::manifest::Manifest;
use crate::step::step;
use crate::versions::workspace_version;

/// Packages the published crates in the order of their dependencies and builds each.
pub(super) fn make(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let packages = published()?;
    // Cargo refuses to package crates that are not published, so each is named.
    let mut package = cargo(&["package", "--locked", "--allow-dirty"]);
    for name in &packages {
        package.args(["--package", name]);
    }
    step("release: crates, built from their packages", package)?;
    let version = workspace_version()?;
    packages.iter().map(|name| copy(&format!("{name}-{version}.crate"), folder)).collect()
}

/// The names of the published crates.
fn published() -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    for folder in libraries().chain(["cli"]) {
        let manifest = Manifest::read(folder)?;
        if manifest.is_published() {
            names.push(manifest.package()?.to_owned());
        }
    }
    Ok(names)
}

fn copy(name: &str, folder: &Path) -> Result<PathBuf, String> {
    let (from, to) = (target_folder().join("package").join(name), folder.join(name));
    fs::copy(&from, &to).map_err(|error| format!("{}: {error}", from.display()))?;
    Ok(to)
}
