//! The text files of the tree that the checks read, without what tools generate or install.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::root::root;

/// A language whose comments the lexer finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    /// Rust.
    Rust,
    /// TypeScript and JavaScript.
    Script,
    /// Python.
    Python,
    /// Settings in TOML or YAML, where only lines that begin with `#` count as comments.
    Settings,
    /// Markdown, prose as a whole.
    Markdown,
}

/// A file of the tree.
pub(crate) struct SourceFile {
    /// Its path below the root, with `/` between folders.
    pub(crate) path: String,
    /// Its language.
    pub(crate) language: Language,
    /// Its text.
    pub(crate) text: String,
}

/// Folders of other people's files, or of generated ones.
const SKIPPED: [&str; 7] = ["node_modules", "dist", "out", "__pycache__", "venv", "build", "fonts"];

/// Every text file below the root, by path.
pub(crate) fn all() -> Result<Vec<SourceFile>, String> {
    let mut paths = Vec::new();
    walk(&root(), &mut paths)?;
    if let Some(own) = listed() {
        paths.retain(|path| own.contains(&shown(path)));
    }
    paths.sort();
    let mut files = Vec::new();
    for path in paths {
        let Some(language) = language(&path) else { continue };
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        files.push(SourceFile { path: shown(&path), language, text });
    }
    Ok(files)
}

/// The paths that git tracks or would add; `None` outside a git checkout.
fn listed() -> Option<HashSet<String>> {
    let mut git = Command::new("git");
    git.args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"]).current_dir(root());
    let output = git.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.split('\0').filter(|path| !path.is_empty()).map(str::to_owned).collect())
}

/// The files below a folder of the tree, by path.
pub(crate) fn below<'a>(files: &'a [SourceFile], folder: &str) -> impl Iterator<Item = &'a SourceFile> {
    let prefix = format!("{folder}/");
    files.iter().filter(move |file| file.path.starts_with(&prefix))
}

/// The folders of `crates/` that have a manifest, sorted.
pub(crate) fn crate_folders() -> Result<Vec<String>, String> {
    let crates = root().join("crates");
    let entries = fs::read_dir(&crates).map_err(|error| format!("{}: {error}", crates.display()))?;
    let mut folders: Vec<String> = entries
        .flatten()
        .filter(|entry| entry.path().join("Cargo.toml").is_file())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    folders.sort();
    Ok(folders)
}

/// A path below the root, with `/` between folders.
fn shown(path: &Path) -> String {
    let below = path.strip_prefix(root()).unwrap_or(path);
    below.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

fn walk(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_generated = SKIPPED.contains(&name.as_str())
            || name.starts_with("target")
            || (name.starts_with('.') && name != ".github")
            || name.ends_with(".egg-info");
        let Ok(kind) = entry.file_type() else { continue };
        if kind.is_dir() && !is_generated {
            walk(&entry.path(), paths)?;
        } else if kind.is_file() && language(&entry.path()).is_some() {
            paths.push(entry.path());
        }
    }
    Ok(())
}

fn language(path: &Path) -> Option<Language> {
    match path.extension()?.to_str()? {
        "rs" => Some(Language::Rust),
        "ts" | "js" | "mjs" => Some(Language::Script),
        // Stubs are generated.
        "py" => Some(Language::Python),
        "toml" | "yml" | "yaml" => Some(Language::Settings),
        "md" => Some(Language::Markdown),
        _ => None,
    }
}
