//! `cargo xtask wrap PATH…`: paragraphs of comments and Markdown with a line that is too wide, wrapped again.

use std::fs;

use crate::files::{self, Language, SourceFile};
use crate::lexer::lex;
use crate::prose::{WIDEST, columns, is_too_wide};
use crate::root::root;
use crate::text_blocks::{blocks, paragraphs};

/// Wraps the files whose paths begin so.
pub(crate) fn run(prefixes: &[&str]) -> Result<(), String> {
    let mut count = 0;
    for file in files::all()? {
        if prefixes.iter().any(|prefix| file.path.starts_with(prefix))
            && let Some(text) = wrapped(&file)
        {
            fs::write(root().join(&file.path), text).map_err(|error| format!("{}: {error}", file.path))?;
            count += 1;
        }
    }
    println!("{count} files wrapped");
    Ok(())
}

/// The text of a file with its wide paragraphs wrapped; `None` without wide paragraphs.
fn wrapped(file: &SourceFile) -> Option<String> {
    let source: Vec<&str> = file.text.lines().collect();
    let mut replaced: Vec<(usize, usize, Vec<String>)> = Vec::new();
    for block in blocks(&file.text, file.language, &lex(&file.text, file.language)) {
        for paragraph in paragraphs(&block) {
            if paragraph.iter().any(|(number, _)| is_too_wide(source[number - 1])) {
                let lines = wrap(&paragraph, &source, file.language);
                replaced.extend(lines.map(|lines| (paragraph[0].0 - 1, paragraph.len(), lines)));
            }
        }
    }
    if replaced.is_empty() {
        return None;
    }
    let mut lines: Vec<String> = source.iter().map(|line| (*line).to_owned()).collect();
    for (first, count, wrapped) in replaced.into_iter().rev() {
        lines.splice(first..first + count, wrapped);
    }
    let end = if file.text.ends_with('\n') { "\n" } else { "" };
    let text = lines.join("\n") + end;
    (text != file.text).then_some(text)
}

/// The lines of a paragraph after wrapping; nothing if it cannot be wrapped: behind code, or with breaks that
/// count.
fn wrap(paragraph: &[(usize, &str)], source: &[&str], language: Language) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let (mut first_prefix, mut next_prefix, mut suffix) = ("", None, "");
    for (index, &(number, text)) in paragraph.iter().enumerate() {
        let line = source[number - 1];
        let text = text.trim_end();
        let at = line.rfind(text)?;
        let (prefix, end) = (&line[..at], &line[at + text.len()..]);
        let is_last = index + 1 == paragraph.len();
        if line.ends_with("  ") || line.ends_with('\\') || (!end.trim().is_empty() && !is_last) {
            return None;
        }
        if index == 0 {
            first_prefix = prefix;
        } else if next_prefix.is_none() {
            next_prefix = Some(prefix.to_owned());
        }
        suffix = end;
        words.push(text);
    }
    let next_prefix = match next_prefix {
        Some(prefix) => prefix,
        None => continuation(first_prefix, language)?,
    };
    let text = words.join(" ");
    let mut words = unbroken(&text);
    if let Some(last) = words.last_mut() {
        last.push_str(suffix);
    }
    let mut lines = Vec::new();
    let mut line = first_prefix.to_owned();
    let mut is_empty = true;
    for word in words {
        let fits = columns(&line) + 1 + columns(&word) <= WIDEST;
        if !is_empty && !fits {
            lines.push(std::mem::replace(&mut line, next_prefix.clone()));
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(&word);
        is_empty = false;
    }
    lines.push(line);
    Some(lines)
}

/// The beginning of a line after one that begins so; nothing behind code.
fn continuation(prefix: &str, language: Language) -> Option<String> {
    let indent = &prefix[..prefix.len() - prefix.trim_start().len()];
    let mark = prefix.trim_start();
    if mark.starts_with("/**") {
        return Some(format!("{indent} * "));
    }
    let marks = ["///", "//!", "//", "#", "*"];
    let known = marks.into_iter().find(|known| mark.starts_with(known) && language != Language::Markdown);
    let (kept, rest) = mark.split_at(known.map_or(0, str::len));
    let rest = rest.trim_matches('"');
    // Behind the marks: blanks, and the marker of a list, below which the text goes on.
    let is_marker = rest.chars().all(|c| c.is_ascii_digit() || " -*+.)>".contains(c));
    is_marker.then(|| format!("{indent}{kept}{}", " ".repeat(columns(rest))))
}

/// The words of a text. Short code between backticks is one word; a mark belongs to the word before it.
fn unbroken(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut is_open = false;
    for word in text.split_whitespace() {
        match words.last_mut() {
            Some(last) if begins_markup(word) || (is_open && columns(last) + columns(word) < WIDEST / 2) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
        if word.matches('`').count() % 2 == 1 {
            is_open = !is_open;
        }
    }
    words
}

/// Whether a word at the beginning of a line would be read as a list's marker, a heading, a quotation or a
/// table.
fn begins_markup(word: &str) -> bool {
    let is_number = word
        .strip_suffix(['.', ')'])
        .is_some_and(|stem| !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_digit()));
    is_number
        || ["-", "+", "*", "–", "="].contains(&word)
        || word.starts_with(['#', '>', '|', '<'])
        || word.starts_with("---")
        || word.starts_with("===")
}

#[cfg(test)]
mod tests {
    use super::wrapped;
    use crate::files::{Language, SourceFile};

    fn wrap(text: &str, language: Language) -> Option<String> {
        wrapped(&SourceFile { path: String::new(), language, text: text.to_owned() })
    }

    #[test]
    fn wide_paragraphs_are_wrapped_with_their_marks() {
        let words = "word ".repeat(30);
        let text = format!(
            "fn f() {{\n    /// {words}end.\n    /// More.\n    ///\n    /// Short\n    /// as it is.\n}}\n"
        );
        let found = wrap(&text, Language::Rust).expect("is wide");
        let lines: Vec<&str> = found.lines().collect();
        assert_eq!(lines[1], format!("    /// {}", "word ".repeat(20).trim_end()));
        assert_eq!(lines[2], format!("    /// {}end. More.", "word ".repeat(10)));
        assert_eq!(lines[3..], ["    ///", "    /// Short", "    /// as it is.", "}"]);
        assert_eq!(wrap(&found, Language::Rust), None);
    }

    #[test]
    fn lists_go_on_below_their_text() {
        let text = format!("- {}\n- short\n", "word ".repeat(30).trim_end());
        let found = wrap(&text, Language::Markdown).expect("is wide");
        assert!(found.lines().nth(1).is_some_and(|line| line.starts_with("  word")), "{found}");
        assert!(found.ends_with("\n- short\n"));
    }

    #[test]
    fn code_and_marks_stay_inside_lines() {
        let text = format!("{}`a b` - c\n", "x".repeat(105) + " ");
        let found = wrap(&text, Language::Markdown).expect("is wide");
        assert!(found.ends_with("\n`a b` - c\n"), "{found}");
        let text = format!("{} - c\n", "x".repeat(109));
        assert_eq!(wrap(&text, Language::Markdown), Some(format!("{} -\nc\n", "x".repeat(109))));
    }

    #[test]
    fn docstrings_keep_their_quotes_and_code_is_left_alone() {
        let text = format!("def f():\n    \"\"\"{}\"\"\"\n", "word ".repeat(30).trim_end());
        let found = wrap(&text, Language::Python).expect("is wide");
        let lines: Vec<&str> = found.lines().collect();
        assert!(
            lines[1].starts_with("    \"\"\"word")
                && lines[2].starts_with("    word")
                && lines[2].ends_with("word\"\"\"")
        );
        assert_eq!(wrap(&format!("let x = 1; // {}\n", "word ".repeat(30)), Language::Rust), None);
    }
}
