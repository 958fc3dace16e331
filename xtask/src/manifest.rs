//! The dependencies that manifests name.

use std::collections::BTreeMap;
use std::fs;

use crate::root::root;

/// The manifest of a crate.
pub(crate) struct Manifest {
    text: String,
}

/// A dependency of a crate.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Dependency {
    /// Its key in the manifest; code names it so, with `_` for `-`.
    pub(crate) key: String,
    /// Its folder below `crates/`, for a crate of the workspace.
    pub(crate) folder: Option<String>,
}

impl Dependency {
    /// Its folder, or the name of its package.
    pub(crate) fn name(&self) -> &str {
        self.folder.as_deref().unwrap_or(&self.key)
    }
}

/// The dependencies of the workspace that are its own crates: their folders by key.
pub(crate) struct Workspace {
    folders: BTreeMap<String, String>,
}

impl Workspace {
    /// Reads it.
    pub(crate) fn read() -> Result<Self, String> {
        let text = fs::read_to_string(root().join("Cargo.toml")).map_err(|error| error.to_string())?;
        Ok(Self::of(&text))
    }

    fn of(text: &str) -> Self {
        let lines = section(text, "[workspace.dependencies]");
        let folders = lines.filter_map(|line| Some((key(line)?.to_owned(), folder(line)?.to_owned())));
        Self { folders: folders.collect() }
    }

    /// The dependencies under `[dependencies]` of a manifest.
    pub(crate) fn dependencies(&self, manifest: &Manifest) -> Vec<Dependency> {
        let lines = section(&manifest.text, "[dependencies]");
        let dependency = |line: &str| {
            let key = key(line)?.to_owned();
            let folder = folder(line).map(str::to_owned).or_else(|| self.folders.get(&key).cloned());
            Some(Dependency { key, folder })
        };
        lines.filter_map(dependency).collect()
    }
}

impl Manifest {
    /// Reads the manifest in that folder of `crates/`.
    pub(crate) fn read(folder: &str) -> Result<Self, String> {
        let path = root().join("crates").join(folder).join("Cargo.toml");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { text })
    }

    /// Whether the package may be published.
    pub(crate) fn is_published(&self) -> bool {
        section(&self.text, "[package]").all(|line| line.trim() != "publish = false")
    }

    /// The name of the package.
    pub(crate) fn package(&self) -> Result<&str, String> {
        let name = section(&self.text, "[package]").find_map(|line| line.strip_prefix("name = "));
        name.map(|name| name.trim_matches('"')).ok_or_else(|| "a manifest has no package name".to_owned())
    }
}

/// The lines of a section.
fn section<'a>(text: &'a str, header: &'a str) -> impl Iterator<Item = &'a str> {
    let lines = text.lines().skip_while(move |line| line.trim() != header).skip(1);
    lines.take_while(|line| !line.starts_with('['))
}

fn key(line: &str) -> Option<&str> {
    let key = line.split(['.', '=', ' ']).next()?;
    (!key.is_empty() && !key.starts_with('#')).then_some(key)
}

/// The folder of a line `… path = "…/folder" …`.
fn folder(line: &str) -> Option<&str> {
    let (_, rest) = line.split_once("path = \"")?;
    rest.split('"').next()?.rsplit('/').next()
}

#[cfg(test)]
mod tests {
    use super::{Manifest, Workspace};

    #[test]
    fn dependencies_are_named_by_folder() {
        let workspace = Workspace::of(
            "[workspace.dependencies]\nrobot-mesh = { package = \"x\", path = \"crates/mesh\" }\nserde = \"1\"\n",
        );
        let text = "[dependencies]\n# A.\nrobot-mesh.workspace = true\nserde = { workspace = true }\nnear = { path = \"../near\" }\n\n[dev-dependencies]\nother = \"1\"\n";
        let found = workspace.dependencies(&Manifest { text: text.to_owned() });
        assert_eq!(found.iter().map(super::Dependency::name).collect::<Vec<_>>(), ["mesh", "serde", "near"]);
    }
}
