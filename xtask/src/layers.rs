//! The dependencies that each crate may have. Edit these lists when a crate is added or removed.

use crate::root::root;

/// A crate's folder, and the only dependencies (not dev-dependencies) that its manifest may name: folders of
/// `crates/`, and packages from the registry. A row whose folder is missing has no effect.
pub(crate) const LAYERS: &[(&str, &[&str])] = &[
    ("number", &[]),
    ("description", &["nalgebra", "number", "serde", "strsim", "thiserror"]),
    ("integrators", &["nalgebra", "number"]),
    ("expression", &["number"]),
    ("native", &["expression", "memmap2", "number", "thiserror"]),
    (
        "core",
        &["description", "expression", "integrators", "nalgebra", "native", "number", "serde", "thiserror"],
    ),
    (
        "simulation",
        &[
            "core",
            "description",
            "differential-equations",
            "integrators",
            "nalgebra",
            "native",
            "number",
            "parry3d-f64",
            "serde",
            "thiserror",
        ],
    ),
    (
        "control",
        &["core", "description", "integrators", "nalgebra", "number", "rsruckig", "simulation", "thiserror"],
    ),
    (
        "batch",
        &["core", "description", "integrators", "native", "number", "rayon", "simulation", "thiserror"],
    ),
    (
        "verification",
        &["core", "description", "integrators", "nalgebra", "number", "serde", "simulation", "thiserror"],
    ),
    ("certified", &["core", "nalgebra", "number", "serde_json"]),
    ("dynamics", &["core", "description", "integrators", "nalgebra", "number", "thiserror", "verification"]),
    ("xml", &["encoding_rs", "roxmltree", "thiserror"]),
    ("mesh", &["nalgebra", "robust"]),
    ("urdf", &["core", "description", "nalgebra", "number", "thiserror", "xml"]),
    ("usd", &["anyhow", "description", "lz4_flex", "mesh", "nalgebra", "openusd", "thiserror", "xml", "zip"]),
    ("mjcf", &["core", "description", "mesh", "nalgebra", "thiserror", "xml"]),
    ("functions", &["core", "description", "expression", "integrators", "number", "simulation", "thiserror"]),
    (
        "robot-dynamics",
        &[
            "batch",
            "control",
            "core",
            "description",
            "functions",
            "integrators",
            "mesh",
            "mjcf",
            "nalgebra",
            "number",
            "png",
            "serde",
            "serde_json",
            "simulation",
            "thiserror",
            "urdf",
            "usd",
            "verification",
            "xml",
        ],
    ),
    ("generate", &["expression", "functions", "number", "robot-dynamics", "thiserror"]),
    (
        "gpu",
        &["bytemuck", "cudarc", "generate", "libloading", "number", "robot-dynamics", "thiserror", "wgpu"],
    ),
];

/// The folders of libraries: the rows above whose folder exists.
pub(crate) fn libraries() -> impl Iterator<Item = &'static str> {
    let exists = |folder: &&str| root().join("crates").join(folder).is_dir();
    LAYERS.iter().map(|(folder, _)| *folder).filter(exists)
}

/// Crates that may depend on anything, and on which no library depends.
pub(crate) const LEAVES: &[&str] = &["c", "cli", "tests", "python", "wasm"];

/// Dependencies that belong to one crate alone.
pub(crate) const OWNED: &[(&str, &str)] = &[
    ("clap", "cli"),
    ("cudarc", "gpu"),
    ("encoding_rs", "xml"),
    ("libloading", "gpu"),
    ("plotters", "cli"),
    ("roxmltree", "xml"),
    ("wasm-bindgen", "wasm"),
    ("wgpu", "gpu"),
];

/// Crates whose top-level modules use only modules before them in `lib.rs`; ARCHITECTURE.md shows their
/// modules in this order. A folder that is missing is passed over.
pub(crate) const ORDERED: &[&str] = &["core", "simulation", "control", "verification"];
