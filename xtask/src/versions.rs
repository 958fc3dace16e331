//! One version for the crates, the C++ library, the Python and npm packages, the lab and the citation.

use std::fs;

use crate::root::root;

/// The line of a file that states the version, up to the version itself.
struct Place {
    path: &'static str,
    before: &'static str,
}

const PLACES: [Place; 5] = [
    Place { path: "cpp/CMakeLists.txt", before: "project(robot_dynamics VERSION " },
    Place { path: "integrations/ros2/robot_dynamics_ros2_control/package.xml", before: "  <version>" },
    Place { path: "CITATION.cff", before: "version: " },
    Place { path: "npm/package.json", before: "  \"version\": \"" },
    // The section of the release.
    Place { path: "CHANGELOG.md", before: "## " },
];

/// Files that must state no version, or the workspace's.
const OPTIONAL: [Place; 2] = [
    // maturin takes it from the workspace.
    Place { path: "python/pyproject.toml", before: "version = \"" },
    Place { path: "lab/package.json", before: "  \"version\": \"" },
];

/// The version of the workspace.
pub(crate) fn workspace_version() -> Result<String, String> {
    let text = read("Cargo.toml")?;
    let version = text.lines().find_map(|line| line.strip_prefix("version = \"")?.strip_suffix('"'));
    version.map(str::to_owned).ok_or_else(|| "Cargo.toml has no [workspace.package] version".to_owned())
}

/// Notes places whose version differs from that of the workspace.
pub(crate) fn check(broken: &mut Vec<String>) -> Result<(), String> {
    let version = workspace_version()?;
    for place in &PLACES {
        check_place(place, &read(place.path)?, &version, true, broken);
    }
    for place in &OPTIONAL {
        check_place(place, &read(place.path)?, &version, false, broken);
    }
    check_dependencies(&read("Cargo.toml")?, &version, broken);
    check_crates(broken)
}

fn read(path: &str) -> Result<String, String> {
    fs::read_to_string(root().join(path)).map_err(|error| format!("{path}: {error}"))
}

/// The first version that a file states must be the given one. The changelog may begin with *Unreleased*.
fn check_place(place: &Place, text: &str, version: &str, is_required: bool, broken: &mut Vec<String>) {
    let Place { path, before } = place;
    let stated = text.lines().filter_map(|line| line.strip_prefix(before)).find(|rest| *rest != "Unreleased");
    let stated = stated.map(|rest| rest.split(['"', ' ', '<']).next().unwrap_or_default());
    match stated {
        None if !is_required => {}
        None => broken.push(format!("{path}: no line `{before}{version}`")),
        Some(stated) if stated == version => {}
        Some(stated) => broken.push(format!("{path}: version {stated}, but the workspace has {version}")),
    }
}

/// The crates of the workspace are required in the workspace's version.
fn check_dependencies(manifest: &str, version: &str, broken: &mut Vec<String>) {
    for line in manifest.lines().filter(|line| line.contains("path = \"crates/")) {
        let Some((_, rest)) = line.split_once("version = \"") else { continue };
        if rest.split('"').next() != Some(version) {
            let name = line.split(' ').next().unwrap_or_default();
            broken.push(format!("Cargo.toml: `{name}` is not required in version {version}"));
        }
    }
}

/// Crates take the version of the workspace.
fn check_crates(broken: &mut Vec<String>) -> Result<(), String> {
    let crates = root().join("crates");
    let folders = fs::read_dir(&crates).map_err(|error| format!("{}: {error}", crates.display()))?;
    for folder in folders.flatten().map(|folder| folder.path()) {
        let Ok(manifest) = fs::read_to_string(folder.join("Cargo.toml")) else { continue };
        if !manifest.lines().any(|line| line == "version.workspace = true") {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            broken.push(format!("crates/{name}/Cargo.toml: write `version.workspace = true`"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Place, check_dependencies, check_place};

    #[test]
    fn another_version_is_noted() {
        let place = Place { path: "CITATION.cff", before: "version: " };
        let mut broken = Vec::new();
        check_place(&place, "title: x\nversion: 0.1.0\n", "0.1.0", true, &mut broken);
        assert_eq!(broken, Vec::<String>::new());
        check_place(&place, "title: x\nversion: 0.2.0\n", "0.1.0", true, &mut broken);
        check_place(&place, "title: x\n", "0.1.0", true, &mut broken);
        assert_eq!(broken.len(), 2, "{broken:?}");
    }

    #[test]
    fn unreleased_changes_come_before_the_version() {
        let place = Place { path: "CHANGELOG.md", before: "## " };
        let mut broken = Vec::new();
        check_place(&place, "## Unreleased\n\n## 0.1.0 – 2026-11-28\n", "0.1.0", true, &mut broken);
        assert_eq!(broken, Vec::<String>::new());
    }

    #[test]
    fn requirements_have_the_version() {
        let line = "robot-x = { path = \"crates/x\", version = \"0.1.0\" }\n";
        let mut broken = Vec::new();
        check_dependencies(line, "0.1.0", &mut broken);
        assert_eq!(broken, Vec::<String>::new());
        check_dependencies(line, "0.2.0", &mut broken);
        assert_eq!(broken.len(), 1);
    }
}
