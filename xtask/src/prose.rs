//! Prose rules: the sentences of comments and Markdown that break one.

use crate::files::{Language, SourceFile};
use crate::lexer::{Kind, Span, lex};
use crate::sentences::{Sentence, sentences};
use crate::text_blocks::{Block, blocks, paragraphs};

/// Longest sentence of documentation, in words.
const LONGEST_IN_DOCS: usize = 35;

/// Longest sentence by the prose rules, in words.
const LONGEST: usize = 25;

/// Widest line of a comment or of Markdown, in columns.
pub(crate) const WIDEST: usize = 110;

/// A rule of prose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Rule {
    /// A sentence opens with a relative clause or with "of".
    Opening,
    /// A sentence of documentation has more than 35 words.
    LongInDocs,
    /// A sentence has more than 25 words.
    Long,
    /// A line of a comment or of Markdown is wider than 110 columns.
    Width,
    /// A sentence has a word or phrase that the prose rules replace.
    Phrase,
}

impl Rule {
    /// Every rule.
    pub(crate) const ALL: [Self; 5] =
        [Self::Opening, Self::LongInDocs, Self::Long, Self::Width, Self::Phrase];

    /// Its name in `allowances.txt` and in measurements.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Opening => "opening",
            Self::LongInDocs => "sentence-35",
            Self::Long => "sentence-25",
            Self::Width => "width",
            Self::Phrase => "phrase",
        }
    }

    /// The demand in words.
    pub(crate) fn demand(self) -> &'static str {
        match self {
            Self::Opening => "no sentence opens with What, Who, Whose, Which, Of or a clause with That",
            Self::LongInDocs => "no sentence of documentation has more than 35 words",
            Self::Long => "no sentence has more than 25 words",
            Self::Width => "no line of a comment or of Markdown is wider than 110 columns",
            Self::Phrase => "no sentence has a phrase that the prose rules replace",
        }
    }

    /// Whether `cargo xtask tidy` checks it.
    pub(crate) fn is_checked(self) -> bool {
        matches!(self, Self::Opening | Self::LongInDocs | Self::Width)
    }
}

/// A place that breaks a rule.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Breach {
    /// The rule.
    pub(crate) rule: Rule,
    /// The line, from 1.
    pub(crate) line: usize,
    /// The sentence's beginning, the phrase, or the width.
    pub(crate) what: String,
}

/// Words and phrases that the prose rules replace.
const PHRASES: &[&str] = &[
    "is no",
    "are no",
    "is none",
    "are none",
    "book",
    "books",
    "door",
    "doors",
    "followers",
    "freedoms",
    "hand over",
    "handed over",
    "hands over",
    "house",
    "knows",
    "ledger",
    "lives",
    "no longer",
    "oracle",
    "oracles",
    "room",
    "rooms",
    "seat",
    "seats",
    "slopes",
    "travel",
    "travels",
    "watch",
    "watched",
    "watches",
];

/// Every breach in a file.
pub(crate) fn breaches(file: &SourceFile) -> Vec<Breach> {
    let spans = lex(&file.text, file.language);
    let blocks = blocks(&file.text, file.language, &spans);
    let mut found = Vec::new();
    for block in &blocks {
        for paragraph in paragraphs(block) {
            for sentence in sentences(&paragraph) {
                check(&sentence, block.is_documentation, &mut found);
            }
        }
    }
    check_width(file, &spans, &blocks, &mut found);
    found.sort_by_key(|breach| breach.line);
    found
}

fn check(sentence: &Sentence, is_documentation: bool, found: &mut Vec<Breach>) {
    let mut add = |rule, what| found.push(Breach { rule, line: sentence.line, what });
    let beginning = || sentence.words.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(" ");
    if opens_badly(sentence) {
        add(Rule::Opening, beginning());
    }
    let count = sentence.word_count();
    if count > LONGEST {
        add(Rule::Long, format!("{count} words: {} …", beginning()));
    }
    if is_documentation && count > LONGEST_IN_DOCS {
        add(Rule::LongInDocs, format!("{count} words: {} …", beginning()));
    }
    for phrase in phrases(sentence) {
        add(Rule::Phrase, phrase.to_owned());
    }
}

fn opens_badly(sentence: &Sentence) -> bool {
    if sentence.words.last().is_some_and(|word| word.trim_end_matches(['*', '_', ')', '"']).ends_with('?')) {
        return false;
    }
    let mut words = sentence.words.iter().map(|word| bare(word).to_lowercase());
    match words.next().unwrap_or_default().as_str() {
        "what" | "whatever" | "who" | "whoever" | "whose" | "whom" | "which" | "of" => true,
        "that" => {
            let next = words.next().unwrap_or_default();
            ["a", "an", "the", "no", "every", "each", "its", "it", "they", "all", "this", "these"]
                .contains(&next.as_str())
        }
        _ => false,
    }
}

/// A word without marks around it.
fn bare(word: &str) -> &str {
    word.trim_matches(|c: char| !c.is_alphanumeric() && c != '`')
}

/// The replaced phrases of a sentence.
fn phrases(sentence: &Sentence) -> Vec<&'static str> {
    let words: Vec<String> = sentence.words.iter().map(|word| bare(word).to_lowercase()).collect();
    let mut found = Vec::new();
    for &phrase in PHRASES {
        let mut parts = phrase.split(' ');
        let (first, second) = (parts.next().unwrap_or_default(), parts.next());
        for (index, word) in words.iter().enumerate() {
            let follows = second.is_none_or(|second| words.get(index + 1).is_some_and(|word| word == second));
            // "There is no such frame" is plain English.
            let is_plain = index > 0 && words[index - 1] == "there";
            if word == first && follows && !is_plain {
                found.push(phrase);
            }
        }
    }
    found
}

/// Adds lines of comments and Markdown that are too wide, but for tables, code and links.
fn check_width(file: &SourceFile, spans: &[Span], blocks: &[Block], found: &mut Vec<Breach>) {
    let mut has_comment = vec![file.language == Language::Markdown; file.text.lines().count() + 1];
    let (mut line, mut counted) = (0, 0);
    for span in spans.iter().filter(|span| matches!(span.kind, Kind::Comment | Kind::Doc)) {
        line += newlines(&file.text[counted..span.start]);
        let last = line + newlines(&file.text[span.start..span.end]);
        for has in &mut has_comment[line..=last] {
            *has = true;
        }
        (line, counted) = (last, span.end);
    }
    let mut is_excepted = vec![false; has_comment.len()];
    for block in blocks {
        for line in block.lines.iter().filter(|line| line.is_table_or_code) {
            is_excepted[line.number - 1] = true;
        }
    }
    for (index, text) in file.text.lines().enumerate() {
        if has_comment[index] && !is_excepted[index] && is_too_wide(text) {
            let what = format!("{} columns", columns(text));
            found.push(Breach { rule: Rule::Width, line: index + 1, what });
        }
    }
}

/// Whether a line is wider than 110 columns without addresses.
pub(crate) fn is_too_wide(line: &str) -> bool {
    line.len() > WIDEST && columns(&without_links(line)) > WIDEST
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|&byte| byte == b'\n').count()
}

/// The width of a line: combining marks have none.
pub(crate) fn columns(text: &str) -> usize {
    text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count()
}

/// The text without addresses: `[text](target)` without its target, words with `://` left out.
fn without_links(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("](") {
        let end = rest[at..].find(')').map_or(rest.len(), |n| at + n);
        kept.push_str(&rest[..at + 2]);
        rest = &rest[end..];
    }
    kept.push_str(rest);
    if kept.contains("://") {
        let words = kept.split(' ').filter(|word| !word.contains("://"));
        kept = words.collect::<Vec<_>>().join(" ");
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::{Breach, Rule, breaches, without_links};
    use crate::files::{Language, SourceFile};

    fn found(text: &str, language: Language) -> Vec<(Rule, usize)> {
        let file = SourceFile { path: String::new(), language, text: text.to_owned() };
        breaches(&file).iter().map(|Breach { rule, line, .. }| (*rule, *line)).collect()
    }

    #[test]
    fn relative_clauses_are_found_and_questions_are_not() {
        let text =
            "Good. What bounds\nit is unknown.\n\nWhich is it? That is why. That the arm\nfalls is clear.\n";
        assert_eq!(found(text, Language::Markdown), [(Rule::Opening, 1), (Rule::Opening, 4)]);
        assert_eq!(found("/// Of the last step.\nfn f() {}", Language::Rust), [(Rule::Opening, 1)]);
    }

    #[test]
    fn long_sentences_count_in_documentation_and_comments() {
        let sentence = "word ".repeat(36);
        assert_eq!(
            found(&format!("{sentence}\n"), Language::Markdown),
            [(Rule::Long, 1), (Rule::LongInDocs, 1), (Rule::Width, 1)]
        );
        let comment = format!("// {}\n// {}\n", "word ".repeat(18), "word ".repeat(18));
        assert_eq!(found(&comment, Language::Rust), [(Rule::Long, 1)]);
    }

    #[test]
    fn tables_code_and_links_may_be_wide() {
        let wide = "x".repeat(120);
        for text in [
            format!("| {wide} |"),
            format!("```\n{wide}\n```"),
            format!("[a](b/{wide})"),
            format!("see https://{wide}"),
        ] {
            assert!(found(&text, Language::Markdown).is_empty(), "{text}");
        }
        assert_eq!(found(&format!("let a = 1; // {wide}"), Language::Rust), [(Rule::Width, 1)]);
        assert!(found(&format!("let a = \"{wide}\";"), Language::Rust).is_empty());
    }

    #[test]
    fn phrases_are_whole_words() {
        assert_eq!(
            found("Roomy, but q is no state. There is no other.\nThe door.", Language::Markdown),
            [(Rule::Phrase, 1), (Rule::Phrase, 2)]
        );
    }

    #[test]
    fn links_have_no_width() {
        assert_eq!(without_links("a [b](c.md) d https://e f"), "a [b]() d f");
    }
}
