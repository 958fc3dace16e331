//! The guide's pages as the generator wants them.
//!
//! `guide/pages` and `docs` hold plain Markdown, which a forge shows and the tests run unchanged. This module
//! turns adjacent code of several languages into tabs, removes lines that rustdoc hides, and adapts links to
//! the site.

// Pages are assembled from pieces, which reads more easily without `write!`.
#![allow(clippy::format_push_string)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::root::root;

/// Folders whose Markdown files are pages, and the beginning of the pages' names.
const FOLDERS: [(&str, &str); 4] =
    [("guide/pages", ""), ("docs", ""), ("docs/explanation", "explanation-"), ("docs/decisions", DECISION)];

/// The beginning of the names of decisions. Their index links to them; the contents list the index only.
const DECISION: &str = "decision-";

/// Other documents, and their names as pages.
const DOCUMENTS: [(&str, &str); 15] = [
    ("NOTATION.md", "notation.md"),
    ("ARCHITECTURE.md", "architecture.md"),
    ("CONTRIBUTING.md", "contributing.md"),
    ("CHANGELOG.md", "changelog.md"),
    ("RELEASE.md", "release.md"),
    ("docs/decisions/README.md", "decisions.md"),
    ("python/README.md", "python-package.md"),
    ("npm/README.md", "npm-package.md"),
    ("integrations/ros2/robot_dynamics_ros2_control/README.md", "ros2-control.md"),
    ("integrations/octave/README.md", "octave.md"),
    ("integrations/julia/README.md", "julia.md"),
    ("lab/README.md", "lab-sources.md"),
    ("bench/README.md", "benchmarks.md"),
    ("bench/robots/README.md", "robot-surveys.md"),
    ("bench/learning/README.md", "contact-benchmarks.md"),
];

/// The first page, and the order of all that follows it.
const HOME: &str = "guide/pages/index.md";
const CONTENTS: &str = "guide/contents.md";

/// Parts of the site that are built elsewhere: links into them stay as they are written.
pub(super) const PARTS: [&str; 2] = ["lab", "rust"];

/// Languages that become tabs where they stand side by side, and their titles.
const LANGUAGES: [(&str, &str); 3] = [("sh", "Command"), ("rust", "Rust"), ("python", "Python")];

/// Languages that the generator highlights.
const KNOWN: [&str; 8] = ["rust", "python", "sh", "toml", "json", "cpp", "c", "cmake"];

/// Writes all pages, and the files that they lead to, into a folder.
pub(super) fn write(folder: &Path) -> Result<(), String> {
    let _ = fs::remove_dir_all(folder);
    let pages = pages()?;
    let mut files = BTreeMap::new();
    for (source, name) in &pages {
        let text = read(&root().join(source))?;
        let mut leads = |target: &str| link(source, target, &pages, &mut files);
        let mut page = staged(&text, &mut leads);
        if source == HOME {
            page += &read(&root().join(CONTENTS))?;
        } else if name.starts_with(DECISION) {
            page.insert_str(0, "---\norphan: true\n---\n\n");
        }
        write_file(&folder.join(name), page.as_bytes())?;
    }
    for (source, target) in &files {
        let path = root().join(source);
        let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        write_file(&folder.join(target), &bytes)?;
    }
    Ok(())
}

/// Every page: its path from the repository's root, and its name in the site.
fn pages() -> Result<BTreeMap<String, String>, String> {
    let mut pages: BTreeMap<String, String> =
        DOCUMENTS.iter().map(|(source, name)| ((*source).into(), (*name).into())).collect();
    for (folder, beginning) in FOLDERS {
        let path = root().join(folder);
        let entries = fs::read_dir(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        for entry in entries.flatten() {
            let file = entry.file_name().to_string_lossy().into_owned();
            let (source, name) = (format!("{folder}/{file}"), format!("{beginning}{file}"));
            if Path::new(&file).extension().is_some_and(|end| end == "md") && !pages.contains_key(&source) {
                if pages.values().any(|taken| *taken == name) {
                    return Err(format!("two pages are called {name}"));
                }
                pages.insert(source, name);
            }
        }
    }
    Ok(pages)
}

/// The target of a page's link in the site; `None` if the site does not have it, as for folders. `files`
/// collects the files that the site needs.
fn link(
    source: &str,
    target: &str,
    pages: &BTreeMap<String, String>,
    files: &mut BTreeMap<String, String>,
) -> Option<String> {
    let (path, anchor) = target.find('#').map_or((target, ""), |at| target.split_at(at));
    if path.is_empty() || path.contains(':') {
        return Some(target.into());
    }
    let inside = normal(&Path::new(source).parent().unwrap_or(Path::new("")).join(path));
    if let Some(page) = pages.get(&inside) {
        return Some(format!("{page}{anchor}"));
    }
    if PARTS.iter().any(|part| path.starts_with(&format!("{part}/"))) {
        return Some(target.into());
    }
    if !root().join(&inside).is_file() {
        return None;
    }
    let placed = inside
        .strip_prefix("docs/images/")
        .map_or_else(|| format!("files/{inside}"), |name| format!("images/{name}"));
    files.insert(inside, placed.clone());
    Some(placed)
}

/// A path without `..`, with slashes.
fn normal(path: &Path) -> String {
    let mut parts: Vec<String> = Vec::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(parts.pop()),
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            _ => {}
        }
    }
    parts.join("/")
}

/// A piece of a page: words, or a block of code.
#[derive(Debug, PartialEq)]
enum Piece<'a> {
    Words(&'a str),
    Code { language: &'a str, lines: Vec<&'a str> },
}

/// A page as the generator takes it.
fn staged(page: &str, leads: &mut dyn FnMut(&str) -> Option<String>) -> String {
    let pieces = pieces(page);
    let mut staged = String::new();
    let mut rest = pieces.as_slice();
    while let Some(first) = rest.first() {
        let side_by_side = tabs(rest);
        if side_by_side.len() > 1 {
            staged += "::::{tab-set}\n";
            for (title, codes) in &side_by_side {
                staged += &format!(":::{{tab-item}} {title}\n:sync: {}\n\n", title.to_lowercase());
                for code in codes {
                    staged += &fenced(code);
                }
                staged += ":::\n";
            }
            staged += "::::\n";
            let taken: usize = side_by_side.iter().map(|(_, codes)| codes.len()).sum();
            let mut left = taken;
            while left > 0 {
                left -= usize::from(matches!(rest[0], Piece::Code { .. }));
                rest = &rest[1..];
            }
        } else {
            match first {
                Piece::Words(line) => staged += &format!("{}\n", with_links(line, leads)),
                code @ Piece::Code { .. } => {
                    staged += &fenced(code);
                }
            }
            rest = &rest[1..];
        }
    }
    staged
}

/// The page's lines, blocks of code each in one piece.
fn pieces(page: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let lines = lines.by_ref().take_while(|line| *line != "```").collect();
            pieces.push(Piece::Code { language, lines });
        } else {
            pieces.push(Piece::Words(line));
        }
    }
    pieces
}

/// The blocks of code at the head of these pieces with nothing but empty lines between, by language; output
/// belongs to what printed it.
fn tabs<'a, 'b>(pieces: &'a [Piece<'b>]) -> Vec<(&'static str, Vec<&'a Piece<'b>>)> {
    let mut tabs: Vec<(&'static str, Vec<&Piece<'_>>)> = Vec::new();
    for (at, piece) in pieces.iter().enumerate() {
        match piece {
            Piece::Words("") if !tabs.is_empty() => {}
            Piece::Words(_) => break,
            Piece::Code { language, .. } => {
                let title = LANGUAGES.iter().find(|(name, _)| first_word(language) == *name);
                let is_new = |title: &str| tabs.iter().all(|(taken, _)| *taken != title);
                match title {
                    // A command without output prepares the next block; it is not an alternative to it.
                    Some(("sh", _)) if !shows_output(&pieces[at + 1..]) => break,
                    Some((_, title)) if is_new(title) => tabs.push((title, vec![piece])),
                    None if !tabs.is_empty() => tabs.last_mut().expect("not empty").1.push(piece),
                    _ => break,
                }
            }
        }
    }
    tabs
}

/// Whether a block of output follows with nothing but empty lines before it.
fn shows_output(pieces: &[Piece<'_>]) -> bool {
    let next = pieces.iter().find(|piece| **piece != Piece::Words(""));
    matches!(next, Some(Piece::Code { language: "text", .. }))
}

fn first_word(language: &str) -> &str {
    language.split([',', ' ']).next().unwrap_or_default()
}

/// A block with its fences, without what rustdoc hides.
fn fenced(piece: &Piece<'_>) -> String {
    let Piece::Code { language, lines } = piece else { return String::new() };
    let language = first_word(language);
    let is_hidden = |line: &str| language == "rust" && (line == "#" || line.starts_with("# "));
    let shown: Vec<&str> = lines.iter().copied().filter(|line| !is_hidden(line)).collect();
    let language = if KNOWN.contains(&language) { language } else { "text" };
    format!("```{language}\n{}\n```\n", shown.join("\n"))
}

/// A line with its Markdown links led to the site; words whose link leads nowhere stay as words.
fn with_links(line: &str, leads: &mut dyn FnMut(&str) -> Option<String>) -> String {
    let mut found = String::new();
    let mut rest = line;
    while let Some(middle) = rest.find("](") {
        let Some(end) = rest[middle..].find(')').map(|end| middle + end) else { break };
        let target = &rest[middle + 2..end];
        match (leads(target), rest[..middle].rfind('[')) {
            // No document of the generator's: the browser follows it as it stands.
            (Some(target), Some(open))
                if PARTS.iter().any(|part| target.starts_with(&format!("{part}/"))) =>
            {
                found += &format!("{}<a href=\"{target}\">{}</a>", &rest[..open], &rest[open + 1..middle]);
            }
            (Some(target), _) => found += &format!("{}]({target})", &rest[..middle]),
            (None, Some(open)) => found += &format!("{}{}", &rest[..open], &rest[open + 1..middle]),
            (None, None) => found += &rest[..=end],
        }
        rest = &rest[end + 1..];
    }
    found + rest
}

fn read(path: &PathBuf) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, bytes));
    written.map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{link, staged};

    #[test]
    fn code_side_by_side_becomes_tabs_without_hidden_lines() {
        let page = "Words.\n\n```rust\n# hidden();\nshown();\n#[test]\n```\n\n```python\nprint(1)\n```\n\n```text\n1\n```\n\nMore.\n";
        let expected = "Words.\n\n::::{tab-set}\n:::{tab-item} Rust\n:sync: rust\n\n```rust\nshown();\n#[test]\n```\n:::\n\
                        :::{tab-item} Python\n:sync: python\n\n```python\nprint(1)\n```\n```text\n1\n```\n:::\n::::\n\nMore.\n";
        assert_eq!(staged(page, &mut |_| None), expected);
    }

    #[test]
    fn one_language_stays_as_it_is() {
        let page = "```python\nprint(1)\n```\n\n```text\n1\n```\n\n```python\nprint(2)\n```\n";
        assert_eq!(staged(page, &mut |_| None), page);
    }

    #[test]
    fn a_command_that_prepares_is_no_tab() {
        let page = "```sh\npip install x\n```\n\n```python\nprint(1)\n```\n\n```text\n1\n```\n";
        assert_eq!(staged(page, &mut |_| None), page);
    }

    #[test]
    fn links_lead_to_the_site() {
        let pages = BTreeMap::from([
            ("guide/pages/load.md".to_owned(), "load.md".to_owned()),
            ("docs/audit.md".into(), "audit.md".into()),
            ("lab/README.md".into(), "lab-sources.md".into()),
        ]);
        let mut files = BTreeMap::new();
        let mut from = |target| link("guide/pages/load.md", target, &pages, &mut files);
        assert_eq!(from("../../docs/audit.md#why").as_deref(), Some("audit.md#why"));
        assert_eq!(from("lab/index.html#knife-edge").as_deref(), Some("lab/index.html#knife-edge"));
        assert_eq!(from("https://example.org").as_deref(), Some("https://example.org"));
        assert_eq!(from("../../robots/panda.urdf").as_deref(), Some("files/robots/panda.urdf"));
        assert_eq!(from("../../robots"), None);
        assert_eq!(
            link("ARCHITECTURE.md", "lab/README.md", &pages, &mut files).as_deref(),
            Some("lab-sources.md")
        );
        assert_eq!(files.into_keys().collect::<Vec<_>>(), ["robots/panda.urdf"]);
    }

    #[test]
    fn links_into_other_parts_are_the_browsers() {
        let page = "See [the lab](lab/index.html#knife-edge).\n";
        let leads = &mut |target: &str| Some(target.to_owned());
        assert_eq!(staged(page, leads), "See <a href=\"lab/index.html#knife-edge\">the lab</a>.\n");
    }

    #[test]
    fn words_whose_link_leads_nowhere_stay() {
        assert_eq!(
            staged("See [the robots](../robots) and `x`.\n", &mut |_| None),
            "See the robots and `x`.\n"
        );
    }
}
