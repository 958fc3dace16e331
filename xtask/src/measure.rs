//! `cargo xtask measure`: the size and the state of the tree in numbers, as Markdown and as JSON.

mod api;
mod duplicates;
mod functions;
mod numbers;
mod report;
mod rust_file;
mod size;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use self::numbers::{Measurement, ProseCount};
use self::rust_file::RustFile;
use crate::files::{self, Language, SourceFile};
use crate::graph;
use crate::modules::Crate;
use crate::prose::{Rule, breaches};
use crate::root::OTHER_TREE;
use crate::tokens::code;

/// Measures the tree, prints a page and writes the numbers as JSON: `--json FILE`, `--tree FOLDER`.
pub(crate) fn run(options: &[&str]) -> Result<(), String> {
    let mut json = None;
    for option in options.chunks(2) {
        match *option {
            ["--json", file] => json = Some(Path::new(file)),
            ["--tree", folder] => OTHER_TREE.set(folder.into()).map_err(|_| "--tree is given twice")?,
            _ => return Err(format!("unknown option: {}", option.join(" "))),
        }
    }
    let sources = files::all()?;
    let crates = graph::crates(&sources)?;
    let measurement = measure(&sources, &crates)?;
    print!("{}", report::markdown(&measurement));
    if let Some(path) = json {
        fs::write(path, report::json(&measurement))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

fn measure(sources: &[SourceFile], crates: &[Crate]) -> Result<Measurement, String> {
    let rust: Vec<RustFile> = sources
        .iter()
        .filter(|file| file.language == Language::Rust && file.path.starts_with("crates/"))
        .map(|file| RustFile {
            path: &file.path,
            text: &file.text,
            code: code(&file.text).1,
            is_test: is_test(&file.path, crates),
        })
        .collect();
    let (prose, phrases) = prose(sources);
    Ok(Measurement {
        crates: size::sizes(&rust)?,
        facade: api::facade(crates)?,
        apis: crates.iter().filter_map(api::of).collect(),
        cycles: graph::cycles(crates),
        prose,
        phrases,
        longest: functions::longest(&rust),
        duplicates: duplicates::find(&rust),
        repeated_types: api::repeated_types(crates),
    })
}

/// Whether a file holds nothing but tests, benchmarks or examples. A file in `src` does if no module of the
/// crate names it without `#[cfg(test)]`.
fn is_test(path: &str, crates: &[Crate]) -> bool {
    let Some((folder, below)) = path.strip_prefix("crates/").and_then(|path| path.split_once('/')) else {
        return false;
    };
    if !below.starts_with("src/") {
        return below != "build.rs";
    }
    let Some(one) = crates.iter().find(|one| one.folder == folder) else { return false };
    !one.modules.iter().any(|module| one.files[module.file].path == path)
}

/// How often each rule of prose is broken, and each phrase occurs, by kind of file.
fn prose(sources: &[SourceFile]) -> (Vec<ProseCount>, Vec<ProseCount>) {
    let mut rules: BTreeMap<Rule, BTreeMap<&'static str, usize>> = BTreeMap::new();
    let mut phrases: BTreeMap<String, BTreeMap<&'static str, usize>> = BTreeMap::new();
    for file in sources {
        let kind = match file.language {
            Language::Rust => "Rust",
            Language::Script => "TypeScript",
            Language::Python => "Python",
            Language::Settings => "settings",
            Language::Markdown => "Markdown",
        };
        for breach in breaches(file) {
            *rules.entry(breach.rule).or_default().entry(kind).or_default() += 1;
            if breach.rule == Rule::Phrase {
                *phrases.entry(breach.what).or_default().entry(kind).or_default() += 1;
            }
        }
    }
    let rules = Rule::ALL.into_iter().map(|rule| ProseCount {
        name: rule.name().to_owned(),
        by_language: rules.remove(&rule).unwrap_or_default(),
    });
    let phrases = phrases.into_iter().map(|(name, by_language)| ProseCount { name, by_language });
    (rules.collect(), phrases.collect())
}
