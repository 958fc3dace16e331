//! Blocks of code that are in two places.

use std::collections::HashMap;

use super::rust_file::RustFile;

/// Fewest lines of a block.
const FEWEST: usize = 8;

/// Equal lines in two places.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Duplicate {
    /// How many lines: without blank lines, comments, imports, and lines of punctuation alone.
    pub(super) lines: usize,
    /// Where it is first: file and line.
    pub(super) first: (String, usize),
    /// Where it is again.
    pub(super) again: (String, usize),
}

/// A line that counts.
struct Line<'a> {
    file: usize,
    number: usize,
    text: &'a str,
}

/// Later copies of earlier code in sources, the longest first.
pub(super) fn find(rust: &[RustFile]) -> Vec<Duplicate> {
    let sources: Vec<(&str, &str, &str)> = rust
        .iter()
        .filter(|file| !file.is_test)
        .map(|file| (file.path, file.text, file.code.as_str()))
        .collect();
    among(&sources)
}

/// The copies among files: path, text, code.
fn among(sources: &[(&str, &str, &str)]) -> Vec<Duplicate> {
    let mut lines = Vec::new();
    for (file, (_, text, code)) in sources.iter().enumerate() {
        let mut in_import = false;
        for (number, (text, code)) in text.lines().zip(code.lines()).enumerate() {
            let start = code.trim_start();
            in_import |= start.starts_with("use ") || (start.starts_with("pub") && start.contains(" use "));
            let counts = !in_import && code.bytes().any(|byte| byte.is_ascii_alphanumeric());
            if code.trim_end().ends_with(';') {
                in_import = false;
            }
            if counts {
                // With its literals, without a comment behind it.
                let text = text.get(..code.trim_end().len()).unwrap_or(text).trim();
                lines.push(Line { file, number: number + 1, text });
            }
        }
    }
    let mut seen: HashMap<Vec<&str>, usize> = HashMap::new();
    let mut found = Vec::new();
    let mut at = 0;
    while at + FEWEST <= lines.len() {
        if lines[at].file != lines[at + FEWEST - 1].file {
            at += 1;
            continue;
        }
        let window: Vec<&str> = lines[at..at + FEWEST].iter().map(|line| line.text).collect();
        let earlier = *seen.entry(window).or_insert(at);
        // A run of equal lines is not a copy of itself.
        if earlier + FEWEST > at {
            at += 1;
            continue;
        }
        let mut count = FEWEST;
        while earlier + count < at
            && at + count < lines.len()
            && lines[at + count].file == lines[at].file
            && lines[earlier + count].file == lines[earlier].file
            && lines[at + count].text == lines[earlier + count].text
        {
            count += 1;
        }
        let place = |line: &Line| (sources[line.file].0.to_owned(), line.number);
        found.push(Duplicate { lines: count, first: place(&lines[earlier]), again: place(&lines[at]) });
        at += count;
    }
    found.sort_by_key(|duplicate| std::cmp::Reverse(duplicate.lines));
    found
}

#[cfg(test)]
mod tests {
    use super::among;

    #[test]
    fn equal_lines_in_two_places_are_a_copy() {
        let block = (0..9).map(|n| format!("    let x{n} = {n};\n\n")).collect::<Vec<_>>().concat();
        let (one, other) =
            (format!("fn a() {{\n{block}}}\n"), format!("use b::{{\n  c,\n}};\nfn d() {{\n{block}}}\n"));
        let found = among(&[("a.rs", &one, &one), ("b.rs", &other, &other)]);
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].lines, &found[0].first, &found[0].again),
            (9, &("a.rs".into(), 2), &("b.rs".into(), 5))
        );
    }

    #[test]
    fn few_or_repeated_lines_are_none() {
        let few = (0..7).map(|n| format!("let x{n} = {n};\n")).collect::<Vec<_>>().concat();
        let repeated = "same();\n".repeat(15);
        let text = format!("{few}first();\n{few}second();\n{repeated}");
        assert!(among(&[("a.rs", &text, &text)]).is_empty());
    }
}
