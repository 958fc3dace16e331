//! Files that a crate's sources read at compile time must be in its package.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::root::root;

/// Notes files that `include_bytes!` or `include_str!` name in a crate's `src` and that `include` of its
/// manifest leaves out.
pub(crate) fn check(broken: &mut Vec<String>) -> Result<(), String> {
    let crates = root().join("crates");
    let folders = fs::read_dir(&crates).map_err(|error| format!("{}: {error}", crates.display()))?;
    for folder in folders.flatten().map(|folder| folder.path()) {
        let Ok(manifest) = fs::read_to_string(folder.join("Cargo.toml")) else { continue };
        let Some(packaged) = manifest.lines().find(|line| line.starts_with("include = ")) else { continue };
        for (source, file) in read_by_sources(&folder) {
            // A file outside the crate is read by tests of documentation alone, which no package runs.
            let Ok(inside) = file.strip_prefix(&folder) else { continue };
            let Some(first) = inside.components().next() else { continue };
            if !packaged.contains(&format!("\"/{}\"", first.as_os_str().display())) {
                let shown = source.strip_prefix(root()).unwrap_or(&source).display();
                broken.push(format!(
                    "{shown} reads {}, which `include` of its Cargo.toml leaves out of the package",
                    inside.display()
                ));
            }
        }
    }
    Ok(())
}

/// Each source of a crate that reads a file when it is compiled, and the file.
fn read_by_sources(folder: &Path) -> Vec<(PathBuf, PathBuf)> {
    let (mut pending, mut found) = (vec![folder.join("src")], Vec::new());
    while let Some(at) = pending.pop() {
        let Ok(entries) = fs::read_dir(&at) else { continue };
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap_or_default();
                for call in ["include_bytes!(\"", "include_str!(\""] {
                    let named = text.split(call).skip(1).filter_map(|rest| rest.split('"').next());
                    found.extend(named.map(|name| (path.clone(), resolve(&at, name))));
                }
            }
        }
    }
    found
}

/// A path relative to a folder, without `..`.
fn resolve(folder: &Path, relative: &str) -> PathBuf {
    let mut path = folder.to_path_buf();
    for part in Path::new(relative).components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    path
}
