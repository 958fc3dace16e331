//! Rules of the tree that the compiler does not know: which crate may use which, how long a file may be, what has
//! an example.

use std::fs;
use std::path::{Path, PathBuf};

use crate::{examples, packaged, rooms};

/// Who may depend on whom: crate folder, and the only dependencies (not dev-dependencies) it may name.
const LAYERS: &[(&str, &[&str])] = &[
    ("number", &[]),
    ("dynamics", &["nalgebra", "number"]),
    (
        "multibody",
        &[
            "differential-equations",
            "dynamics",
            "expression",
            "nalgebra",
            "native",
            "number",
            "parry3d-f64",
            "rayon",
            "serde",
            "strsim",
            "thiserror",
        ],
    ),
    (
        "robot-dynamics",
        &[
            "dynamics",
            "functions",
            "mjcf",
            "multibody",
            "nalgebra",
            "png",
            "robot-mesh",
            "robot-xml",
            "serde",
            "serde_json",
            "thiserror",
            "urdf",
        ],
    ),
    ("mesh", &["nalgebra", "robust", "stl_io", "tobj"]),
    ("gpu", &["bytemuck", "cudarc", "dynamics", "generate", "multibody", "number", "thiserror", "wgpu"]),
    ("expression", &["number"]),
    ("native", &["expression", "memmap2", "number", "thiserror"]),
    ("functions", &["dynamics", "expression", "multibody", "number", "thiserror"]),
    (
        "generate",
        &["dynamics", "expression", "functions", "multibody", "number", "robot-dynamics", "thiserror"],
    ),
    ("xml", &["roxmltree", "thiserror"]),
    ("urdf", &["dynamics", "multibody", "nalgebra", "robot-xml", "serde", "thiserror"]),
    ("mjcf", &["dynamics", "multibody", "nalgebra", "robot-mesh", "robot-xml", "thiserror"]),
];

/// Dependencies that belong to one crate alone.
const OWNED: &[(&str, &str)] = &[
    ("clap", "cli"),
    ("cudarc", "gpu"),
    ("plotters", "cli"),
    ("roxmltree", "xml"),
    ("wasm-bindgen", "wasm"),
    ("wgpu", "gpu"),
];

/// Longest source file, tests not counted.
const MOST_LINES: usize = 400;

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the root").into()
}

/// Runs every rule and reports all that is broken at once.
pub(crate) fn check() -> Result<(), String> {
    let mut broken = Vec::new();
    check_layers(&mut broken)?;
    rooms::check(&mut broken)?;
    packaged::check(&mut broken)?;
    check_sources(&mut broken)?;
    if broken.is_empty() {
        println!("tidy: ok");
        Ok(())
    } else {
        Err(format!("tidy: {} rules broken:\n  {}", broken.len(), broken.join("\n  ")))
    }
}

fn check_layers(broken: &mut Vec<String>) -> Result<(), String> {
    let crates = root().join("crates");
    let folders = fs::read_dir(&crates).map_err(|error| format!("{}: {error}", crates.display()))?;
    for folder in folders.flatten() {
        let name = folder.file_name().to_string_lossy().into_owned();
        let manifest = folder.path().join("Cargo.toml");
        let Ok(text) = fs::read_to_string(&manifest) else { continue };
        let allowed = LAYERS.iter().find(|(layer, _)| *layer == name).map(|(_, allowed)| *allowed);
        for dependency in dependencies(&text) {
            if allowed.is_some_and(|allowed| !allowed.contains(&dependency)) {
                broken.push(format!("crates/{name} must not depend on {dependency}"));
            }
            if let Some((_, owner)) = OWNED.iter().find(|(owned, _)| *owned == dependency)
                && *owner != name
            {
                broken.push(format!("only crates/{owner} may know {dependency}; crates/{name} names it"));
            }
        }
    }
    Ok(())
}

/// The names under `[dependencies]` of a manifest.
fn dependencies(manifest: &str) -> impl Iterator<Item = &str> {
    let section = manifest.lines().skip_while(|line| line.trim() != "[dependencies]").skip(1);
    section
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split(['.', '=', ' ']).next())
        .filter(|name| !name.is_empty() && !name.starts_with('#'))
}

fn check_sources(broken: &mut Vec<String>) -> Result<(), String> {
    let mut pending = ["crates", "xtask", "bench", "guide"].map(|folder| root().join(folder)).to_vec();
    while let Some(folder) = pending.pop() {
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        for entry in entries.flatten() {
            let path = entry.path();
            if path.is_dir() {
                if path.file_name().is_some_and(|name| name != "target") {
                    pending.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                check_source(&path, broken)?;
            }
        }
    }
    Ok(())
}

fn check_source(path: &Path, broken: &mut Vec<String>) -> Result<(), String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let shown = path.strip_prefix(root()).unwrap_or(path).display().to_string();
    let is_test = shown.contains("/tests/") || shown.contains("/benches/");
    let lines = text.lines().take_while(|line| line.trim() != "#[cfg(test)]").count();
    if !is_test && lines > MOST_LINES {
        broken.push(format!(
            "{shown}: {lines} lines, at most {MOST_LINES} (tests not counted); split it by concept"
        ));
    }
    if !text.starts_with("//!") && !is_test {
        broken.push(format!("{shown}: say in a first line `//!` what this file is for"));
    }
    if examples::LIBRARIES
        .iter()
        .any(|library| path.starts_with(root().join("crates").join(library).join("src")))
    {
        for function in examples::without_example(&text) {
            broken.push(format!("{shown}: give `{function}` an example in its documentation"));
        }
    }
    Ok(())
}
