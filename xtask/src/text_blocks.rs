//! Comments and Markdown as blocks of lines, and their paragraphs.

use crate::files::Language;
use crate::lexer::{Kind, Span};

/// A line of prose.
#[derive(Debug)]
pub(crate) struct Line {
    /// Its number in the file, from 1.
    pub(crate) number: usize,
    /// Its text without the comment's marks.
    pub(crate) text: String,
    /// Whether it belongs to a table or to code, and is not prose.
    pub(crate) is_table_or_code: bool,
}

/// Lines of comments that belong together, or a file of Markdown.
#[derive(Debug)]
pub(crate) struct Block {
    /// Its lines.
    pub(crate) lines: Vec<Line>,
    /// Whether it is documentation, and not a comment inside code.
    pub(crate) is_documentation: bool,
}

/// A paragraph: lines with their numbers.
pub(crate) type Paragraph<'a> = Vec<(usize, &'a str)>;

/// The blocks of a file, given its parts.
pub(crate) fn blocks(text: &str, language: Language, spans: &[Span]) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut line, mut counted) = (1, 0);
    // Whether the last block is of line comments, alone on their lines, and its last line.
    let mut open: Option<(Kind, usize)> = None;
    for span in spans.iter().filter(|span| matches!(span.kind, Kind::Comment | Kind::Doc)) {
        line += count_newlines(&text[counted..span.start]);
        counted = span.start;
        let comment = &text[span.start..span.end];
        let marks = line_marks(comment, language);
        let before = text[..span.start].rsplit('\n').next().unwrap_or_default();
        let is_alone = before.trim().is_empty();
        if let Some(marks) = marks {
            let content = comment[marks..].strip_prefix(' ').unwrap_or(&comment[marks..]);
            let content = Line { number: line, text: content.to_owned(), is_table_or_code: false };
            match (open, blocks.last_mut()) {
                (Some((kind, last)), Some(block)) if is_alone && kind == span.kind && last + 1 == line => {
                    block.lines.push(content);
                }
                _ => {
                    let is_documentation = span.kind == Kind::Doc;
                    blocks.push(Block { lines: vec![content], is_documentation });
                }
            }
            open = is_alone.then_some((span.kind, line));
        } else {
            let is_documentation = span.kind == Kind::Doc;
            blocks.push(Block { lines: long_comment(comment, language, line), is_documentation });
            open = None;
        }
    }
    for block in &mut blocks {
        mark(&mut block.lines);
    }
    blocks
}

fn count_newlines(text: &str) -> usize {
    text.bytes().filter(|&byte| byte == b'\n').count()
}

/// The length of the marks of a line comment.
fn line_marks(comment: &str, language: Language) -> Option<usize> {
    match language {
        Language::Markdown => None,
        Language::Python | Language::Settings => comment.starts_with('#').then_some(1),
        Language::Rust | Language::Script => {
            let slashes = comment.bytes().take_while(|&byte| byte == b'/').count();
            (slashes >= 2).then(|| if comment.starts_with("//!") { 3 } else { slashes })
        }
    }
}

/// The lines of a block comment, a docstring or a file of Markdown.
fn long_comment(comment: &str, language: Language, first: usize) -> Vec<Line> {
    let inner = match language {
        Language::Markdown => comment,
        Language::Python => comment.trim_matches(['"', '\'']),
        _ => comment.trim_start_matches(['/', '*', '!']).trim_end_matches(['/', '*']),
    };
    let lines: Vec<&str> = inner.split('\n').map(|line| line.trim_end_matches('\r')).collect();
    // A docstring's lines are indented as its code is.
    let indents = lines.iter().skip(1).filter(|line| !line.trim().is_empty()).map(|line| indent(line));
    let common = if language == Language::Markdown { 0 } else { indents.min().unwrap_or(0) };
    let strip = |(index, line): (usize, &&str)| {
        let line = if index == 0 { *line } else { line.get(common..).unwrap_or("") };
        let line = match language {
            Language::Rust | Language::Script => {
                line.strip_prefix("* ").or_else(|| line.strip_prefix('*')).unwrap_or(line)
            }
            _ => line,
        };
        let text = if language == Language::Markdown { line } else { line.trim_end() };
        Line { number: first + index, text: text.to_owned(), is_table_or_code: false }
    };
    lines.iter().enumerate().map(strip).collect()
}

fn indent(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}

/// Marks lines of tables and of code: fences, indented blocks, Python's examples.
fn mark(lines: &mut [Line]) {
    let (mut fence, mut in_list, mut after_blank, mut in_example) = (None::<char>, false, true, false);
    let mut in_code = false;
    for line in lines {
        let trimmed = line.text.trim_start();
        let is_fence = |mark: char| trimmed.starts_with(&mark.to_string().repeat(3));
        if let Some(mark) = fence {
            line.is_table_or_code = true;
            if is_fence(mark) {
                fence = None;
            }
            continue;
        }
        if trimmed.is_empty() {
            (after_blank, in_example) = (true, false);
            continue;
        }
        let opened = ['`', '~'].into_iter().find(|&mark| is_fence(mark));
        let is_item = list_marker(trimmed).is_some();
        if indent(&line.text) == 0 && after_blank {
            in_list = is_item;
        } else if is_item {
            in_list = true;
        }
        in_example |= trimmed.starts_with(">>>");
        in_code = indent(&line.text) >= 4 && !in_list && !is_item && (after_blank || in_code);
        if opened.is_some() {
            fence = opened;
            line.is_table_or_code = true;
        } else if trimmed.starts_with('|') || in_example || in_code {
            line.is_table_or_code = true;
        }
        after_blank = false;
    }
}

/// The length of a list's marker with the blank behind it.
fn list_marker(text: &str) -> Option<usize> {
    if ["- ", "* ", "+ "].iter().any(|marker| text.starts_with(marker)) {
        return Some(2);
    }
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let rest = &text[digits..];
    let is_number = (1..=3).contains(&digits) && (rest.starts_with(". ") || rest.starts_with(") "));
    is_number.then_some(digits + 2)
}

/// The paragraphs of a block: no headings, tables, code or markup.
pub(crate) fn paragraphs(block: &Block) -> Vec<Paragraph<'_>> {
    let mut paragraphs = vec![Paragraph::new()];
    let mut last_indent = 0;
    let mut in_markup = false;
    for line in &block.lines {
        let mut text = line.text.trim_start();
        let open = paragraphs.last_mut().expect("one is open");
        in_markup |= text.starts_with("<!--");
        let is_underline = text.len() >= 3 && text.bytes().all(|byte| byte == b'-' || byte == b'=');
        if is_underline {
            // The line before is a heading.
            open.pop();
        }
        let is_prose = !(line.is_table_or_code
            || in_markup
            || is_underline
            || text.is_empty()
            || text.starts_with('#')
            || text.starts_with('<')
            || text.starts_with(":::")
            || is_link_definition(text));
        if text.contains("-->") {
            in_markup = false;
        }
        if !is_prose {
            paragraphs.push(Paragraph::new());
            continue;
        }
        text = text.strip_prefix("> ").unwrap_or(text);
        let marker = list_marker(text);
        let indent = indent(&line.text);
        // The description of a parameter is deeper than the parameter before it and the one after it.
        let is_other_level = indent.abs_diff(last_indent) >= 4;
        last_indent = indent;
        text = &text[marker.unwrap_or(0)..];
        if marker.is_some() || is_other_level {
            paragraphs.push(Paragraph::new());
        }
        paragraphs.last_mut().expect("one is open").push((line.number, text));
    }
    paragraphs.retain(|paragraph| !paragraph.is_empty());
    paragraphs
}

fn is_link_definition(text: &str) -> bool {
    text.starts_with('[') && text.find("]:").is_some_and(|at| !text[..at].contains(' '))
}

#[cfg(test)]
mod tests {
    use super::{blocks, paragraphs};
    use crate::files::Language;
    use crate::lexer::lex;

    fn texts(text: &str, language: Language) -> Vec<String> {
        let join = |paragraph: &Vec<(usize, &str)>| {
            let lines = paragraph.iter().map(|(number, text)| format!("{number}:{text}"));
            lines.collect::<Vec<_>>().join(" ")
        };
        let blocks = blocks(text, language, &lex(text, language));
        blocks.iter().flat_map(|block| paragraphs(block).iter().map(join).collect::<Vec<_>>()).collect()
    }

    #[test]
    fn comments_on_lines_below_each_other_are_a_paragraph() {
        let text = "/// A b\n/// c.\n///\n/// D.\n// E.\nlet x = 1; // F.\n// G.";
        assert_eq!(texts(text, Language::Rust), ["1:A b 2:c.", "4:D.", "5:E.", "6:F.", "7:G."]);
    }

    #[test]
    fn markdown_has_lists_tables_code_and_headings() {
        let text = "# No\nA\nb.\n\n- C\n  d\n- E\n\n| no |\n\n    no\n\n```\nno\n```\n1. F\n\n<!-- no\nno -->\n[x]: y\nG\n";
        assert_eq!(texts(text, Language::Markdown), ["2:A 3:b.", "5:C 6:d", "7:E", "16:F", "21:G"]);
    }

    #[test]
    fn docstrings_have_sections_and_examples() {
        let text = "def f():\n    \"\"\"A.\n\n    Parameters\n    ----------\n    q : array\n        B.\n    v : array\n        C.\n\n    >>> f()\n    1\n    \"\"\"\n";
        assert_eq!(texts(text, Language::Python), ["2:A.", "6:q : array", "7:B.", "8:v : array", "9:C."]);
    }

    #[test]
    fn block_comments_lose_their_stars() {
        assert_eq!(texts("/**\n * A\n * b.\n */", Language::Script), ["2:A 3:b."]);
    }
}
