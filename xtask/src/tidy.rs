//! Rules of the tree that the compiler does not check: layering, cycles of files, the length of files,
//! examples, prose.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::allowances::{self, Counts};
use crate::files::{self, Language, SourceFile};
use crate::layers::libraries;
use crate::prose::breaches;
use crate::{examples, graph, packages, versions};

/// Longest source file, tests not counted.
const MOST_LINES: usize = 400;

/// The rule against cycles, in `allowances.txt`. A file's count is the number of files in its cycle.
const CYCLE: &str = "cycle";

/// Folders whose Rust sources have a longest length and a first line that tells their purpose.
const CHECKED: [&str; 4] = ["crates", "xtask", "bench", "guide"];

/// How `xtask/allowances.txt` is treated.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Allowances {
    /// It is compared.
    Compare,
    /// Its counts are lowered.
    Lower,
    /// Its counts become those of the tree.
    Replace,
}

/// Runs every rule and reports all that is broken at once.
pub(crate) fn check(treatment: Allowances) -> Result<(), String> {
    let sources = files::all()?;
    let mut broken = Vec::new();
    let (crates, prose) = std::thread::scope(|scope| {
        let crates = scope.spawn(|| graph::crates(&sources));
        let prose = prose(&sources);
        (crates.join().unwrap_or_else(|_| Err("reading the modules panicked".into())), prose)
    });
    let crates = crates?;
    let (mut counts, mut shown) = prose;
    for (paths, cycle) in graph::cycles(&crates) {
        for (at, path) in paths.iter().enumerate() {
            let key = (CYCLE.to_owned(), path.clone());
            counts.insert(key.clone(), paths.len());
            let text =
                if at == 0 { format!(" files use each other: {cycle}") } else { format!(" as {}", paths[0]) };
            shown.insert(key, text);
        }
    }
    let allowed = allowances::read()?;
    if treatment != Allowances::Compare {
        return allowances::write(&counts, &allowed, treatment == Allowances::Replace);
    }
    graph::check(&crates, &mut broken)?;
    packages::check(&mut broken)?;
    versions::check(&mut broken)?;
    for folder in CHECKED {
        for file in files::below(&sources, folder).filter(|file| file.language == Language::Rust) {
            check_source(file, &mut broken);
        }
    }
    for library in libraries() {
        check_examples(library, &sources, &mut broken);
    }
    broken.extend(allowances::compare(&counts, &allowed, |rule, path| {
        shown.get(&(rule.to_owned(), path.to_owned())).cloned().unwrap_or_default()
    }));
    if broken.is_empty() {
        println!("tidy: ok");
        Ok(())
    } else {
        Err(format!("tidy: {} rules broken:\n  {}", broken.len(), broken.join("\n  ")))
    }
}

/// Prints every breach of a rule of prose in files whose paths begin so, those that only `measure` counts
/// included.
pub(crate) fn list_prose(prefixes: &[&str]) -> Result<(), String> {
    let mut count = 0;
    for file in files::all()? {
        if prefixes.iter().any(|prefix| file.path.starts_with(prefix)) {
            for breach in breaches(&file) {
                println!("{}:{}: {}: {}", file.path, breach.line, breach.rule.name(), breach.what);
                count += 1;
            }
        }
    }
    println!("{count} breaches");
    Ok(())
}

/// How often each file breaks each rule of prose, and where.
fn prose(sources: &[SourceFile]) -> (Counts, BTreeMap<(String, String), String>) {
    let (mut counts, mut shown) = (Counts::new(), BTreeMap::new());
    for file in sources {
        for breach in breaches(file).iter().filter(|breach| breach.rule.is_checked()) {
            let key = (breach.rule.name().to_owned(), file.path.clone());
            *counts.entry(key.clone()).or_default() += 1;
            let text = shown.entry(key).or_insert_with(|| format!(" {}", breach.rule.demand()));
            let _ = write!(text, "\n    {}:{}: {}", file.path, breach.line, breach.what);
        }
    }
    (counts, shown)
}

fn check_source(file: &SourceFile, broken: &mut Vec<String>) {
    let SourceFile { path, text, .. } = file;
    let is_test = path.contains("/tests/") || path.contains("/benches/");
    let lines = text.lines().take_while(|line| line.trim() != "#[cfg(test)]").count();
    if !is_test && lines > MOST_LINES {
        broken.push(format!(
            "{path}: {lines} lines, at most {MOST_LINES} (tests not counted); split it by concept"
        ));
    }
    if !text.starts_with("//!") && !is_test {
        broken.push(format!("{path}: say in a first line `//!` what this file is for"));
    }
}

/// Reports the public functions of a library whose documentation has no example.
fn check_examples(library: &str, sources: &[SourceFile], broken: &mut Vec<String>) {
    let folder = format!("crates/{library}/src");
    let exports = files::below(sources, &folder).find(|file| file.path == format!("{folder}/lib.rs"));
    let exports = exports.map_or("", |file| &file.text);
    for SourceFile { path, text, .. } in files::below(sources, &folder) {
        let module = path[folder.len() + 1..].split(['/', '.']).next().unwrap_or_default();
        let missing = examples::without_example(text).into_iter();
        for function in missing.filter(|function| examples::is_shown(exports, module, function)) {
            broken.push(format!("{path}: give `{function}` an example in its documentation"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::prose;
    use crate::files::{Language, SourceFile};
    use crate::prose::Rule;

    #[test]
    fn only_checked_rules_are_counted() {
        let text = "What is this.\n".to_owned();
        let (counts, shown) =
            prose(&[SourceFile { path: "a.md".into(), language: Language::Markdown, text }]);
        let key = (Rule::Opening.name().to_owned(), "a.md".to_owned());
        assert_eq!(counts.get(&key), Some(&1));
        assert!(shown[&key].contains("a.md:1: What is this."));
    }
}
