//! The numbers as Markdown and as JSON.

use std::fmt::Write;

use super::numbers::{Measurement, ProseCount};

/// Kinds of files, in the order of columns.
const KINDS: [&str; 5] = ["Rust", "Python", "TypeScript", "Markdown", "settings"];

/// How many duplicates and repeated names the page lists.
const LISTED: usize = 20;

/// A page with tables.
pub(super) fn markdown(measurement: &Measurement) -> String {
    let mut page = String::from("# Measurements of the tree\n");
    summary(measurement, &mut page);
    sizes(measurement, &mut page);
    names(measurement, &mut page);
    prose(measurement, &mut page);
    lists(measurement, &mut page);
    page
}

/// The sum of what a list of things has.
fn total<T>(things: &[T], of: impl Fn(&T) -> usize) -> usize {
    things.iter().map(of).sum()
}

fn sum(count: &ProseCount) -> usize {
    count.by_language.values().sum()
}

fn summary(measurement: &Measurement, page: &mut String) {
    let Measurement { crates, facade, apis, cycles, prose, longest, duplicates, repeated_types, .. } =
        measurement;
    page.push_str("\n| quantity | value |\n| --- | ---: |\n");
    let mut row = |name: &str, value: String| {
        let _ = writeln!(page, "| {name} | {value} |");
    };
    row("crates", crates.len().to_string());
    row("files of sources", total(crates, |one| one.files).to_string());
    row("lines of sources", total(crates, |one| one.lines).to_string());
    row("of these with code", total(crates, |one| one.code_lines).to_string());
    row("lines of tests and examples", total(crates, |one| one.test_lines).to_string());
    row("names at the root of the facade", facade.root.len().to_string());
    row("public items and modules that the facade leads to", facade.total.to_string());
    row("public items of all libraries", total(apis, |api| api.items).to_string());
    row("public error types", total(apis, |api| api.errors.len()).to_string());
    row("cycles between files", cycles.len().to_string());
    row("files in cycles", total(cycles, |(files, _)| files.len()).to_string());
    let largest = cycles.iter().map(|(files, _)| files.len()).max().unwrap_or(0);
    row("files in the largest cycle", largest.to_string());
    for count in prose {
        row(&format!("breaches of `{}`", count.name), sum(count).to_string());
    }
    row("lines of the longest function", longest.first().map_or(0, |one| one.lines).to_string());
    row("duplicated blocks of 8 lines or more", duplicates.len().to_string());
    row("lines in them", total(duplicates, |one| one.lines).to_string());
    row("type names defined more than once", repeated_types.len().to_string());
    let within = repeated_types.iter().filter(|(_, files)| is_within_one(files)).count();
    row("of these more than once in one crate", within.to_string());
}

/// Whether two of these files are of one crate.
fn is_within_one(files: &[String]) -> bool {
    let mut folders: Vec<&str> = files.iter().filter_map(|file| file.split('/').nth(1)).collect();
    folders.sort_unstable();
    folders.windows(2).any(|pair| pair[0] == pair[1])
}

fn sizes(measurement: &Measurement, page: &mut String) {
    page.push_str(
        "\n## Crates\n\n| crate | files | lines | with code | tests |\n| --- | ---: | ---: | ---: | ---: |\n",
    );
    for one in &measurement.crates {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} |",
            one.folder, one.files, one.lines, one.code_lines, one.test_lines
        );
    }
}

fn names(measurement: &Measurement, page: &mut String) {
    page.push_str("\n## Public names\n\n| library | at the root | items | error types |\n| --- | ---: | ---: | ---: |\n");
    for api in &measurement.apis {
        let _ = writeln!(page, "| {} | {} | {} | {} |", api.folder, api.root, api.items, api.errors.len());
    }
    page.push_str("\nError types:\n\n");
    for api in measurement.apis.iter().filter(|api| !api.errors.is_empty()) {
        let _ = writeln!(page, "- {}: {}", api.folder, api.errors.join(", "));
    }
}

fn prose(measurement: &Measurement, page: &mut String) {
    let mut table = |counts: &[ProseCount], head: &str| {
        let _ = writeln!(page, "\n| {head} | {} | all |\n| --- |{}", KINDS.join(" | "), " ---: |".repeat(6));
        for count in counts {
            let cells = KINDS.map(|kind| count.by_language.get(kind).copied().unwrap_or(0).to_string());
            let _ = writeln!(page, "| {} | {} | {} |", count.name, cells.join(" | "), sum(count));
        }
    };
    table(&measurement.prose, "rule of prose");
    table(&measurement.phrases, "phrase");
}

fn lists(measurement: &Measurement, page: &mut String) {
    page.push_str("\n## Cycles between files\n\n");
    for (files, cycle) in &measurement.cycles {
        let folder = files[0].split("/src/").next().unwrap_or_default();
        let _ = writeln!(page, "- {folder}: {} files; {cycle}", files.len());
    }
    page.push_str("\n## Longest functions\n\n| lines | function | where |\n| ---: | --- | --- |\n");
    for one in &measurement.longest {
        let _ = writeln!(page, "| {} | `{}` | {}:{} |", one.lines, one.name, one.path, one.line);
    }
    page.push_str("\n## Duplicated blocks\n\n| lines | first | again |\n| ---: | --- | --- |\n");
    for one in measurement.duplicates.iter().take(LISTED) {
        let (first, again) = (&one.first, &one.again);
        let _ = writeln!(page, "| {} | {}:{} | {}:{} |", one.lines, first.0, first.1, again.0, again.1);
    }
    page.push_str(
        "\n## Type names defined more than once\n\n| name | times | where |\n| --- | ---: | --- |\n",
    );
    for (name, files) in measurement.repeated_types.iter().take(LISTED) {
        let shown: Vec<&str> = files.iter().map(|file| file.trim_start_matches("crates/")).collect();
        let _ = writeln!(page, "| `{name}` | {} | {} |", files.len(), shown.join(", "));
    }
}

/// All numbers and lists as JSON.
pub(super) fn json(measurement: &Measurement) -> String {
    let Measurement { crates, facade, apis, cycles, prose, phrases, longest, duplicates, repeated_types } =
        measurement;
    let fields = [
        (
            "crates",
            list(crates, |one| {
                format!(
                    "{{\"crate\": {}, \"files\": {}, \"lines\": {}, \"code_lines\": {}, \"test_lines\": {}}}",
                    text(&one.folder),
                    one.files,
                    one.lines,
                    one.code_lines,
                    one.test_lines
                )
            }),
        ),
        ("facade_root", list(facade.root.iter().collect::<Vec<_>>().as_slice(), |name| text(name))),
        ("facade_total", facade.total.to_string()),
        (
            "libraries",
            list(apis, |api| {
                format!(
                    "{{\"library\": {}, \"root\": {}, \"items\": {}, \"errors\": {}}}",
                    text(&api.folder),
                    api.root,
                    api.items,
                    texts(&api.errors)
                )
            }),
        ),
        (
            "cycles",
            list(cycles, |(files, shown)| {
                format!("{{\"files\": {}, \"shortest\": {}}}", texts(files), text(shown))
            }),
        ),
        ("prose", list(prose, prose_json)),
        ("phrases", list(phrases, prose_json)),
        (
            "longest_functions",
            list(longest, |one| {
                format!(
                    "{{\"function\": {}, \"path\": {}, \"line\": {}, \"lines\": {}}}",
                    text(&one.name),
                    text(&one.path),
                    one.line,
                    one.lines
                )
            }),
        ),
        (
            "duplicates",
            list(duplicates, |one| {
                let place = |(path, line): &(String, usize)| text(&format!("{path}:{line}"));
                format!(
                    "{{\"lines\": {}, \"first\": {}, \"again\": {}}}",
                    one.lines,
                    place(&one.first),
                    place(&one.again)
                )
            }),
        ),
        (
            "repeated_types",
            list(repeated_types, |(name, files)| {
                format!("{{\"name\": {}, \"files\": {}}}", text(name), texts(files))
            }),
        ),
    ];
    let fields = fields.map(|(name, value)| format!("  \"{name}\": {value}"));
    format!("{{\n{}\n}}\n", fields.join(",\n"))
}

fn prose_json(count: &ProseCount) -> String {
    let kinds = count.by_language.iter().map(|(kind, count)| format!("{}: {count}", text(kind)));
    let kinds = kinds.collect::<Vec<_>>().join(", ");
    format!("{{\"name\": {}, \"total\": {}, \"by_kind\": {{{kinds}}}}}", text(&count.name), sum(count))
}

fn list<T>(things: &[T], shown: impl Fn(&T) -> String) -> String {
    let lines: Vec<String> = things.iter().map(|thing| format!("    {}", shown(thing))).collect();
    if lines.is_empty() { "[]".to_owned() } else { format!("[\n{}\n  ]", lines.join(",\n")) }
}

fn texts(things: &[String]) -> String {
    format!("[{}]", things.iter().map(|thing| text(thing)).collect::<Vec<_>>().join(", "))
}

/// A text of JSON.
fn text(text: &str) -> String {
    let mut shown = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => shown.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(shown, "\\u{:04x}", u32::from(c));
            }
            c => shown.push(c),
        }
    }
    shown.push('"');
    shown
}

#[cfg(test)]
mod tests {
    use super::{is_within_one, text};

    #[test]
    fn texts_of_json_are_escaped() {
        assert_eq!(text("a\"\\\n"), "\"a\\\"\\\\\\u000a\"");
    }

    #[test]
    fn files_of_one_crate_are_found() {
        let files = ["crates/a/src/b.rs", "crates/c/src/d.rs", "crates/a/src/e.rs"].map(str::to_owned);
        assert!(is_within_one(&files) && !is_within_one(&files[..2]));
    }
}
