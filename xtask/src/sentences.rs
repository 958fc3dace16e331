//! Paragraphs as sentences.

use crate::text_blocks::Paragraph;

/// A sentence of prose.
#[derive(Debug)]
pub(crate) struct Sentence {
    /// The line of its first word, from 1.
    pub(crate) line: usize,
    /// Its words with their marks; code and formulas are one word.
    pub(crate) words: Vec<String>,
}

impl Sentence {
    /// How many words have a letter or a digit.
    pub(crate) fn word_count(&self) -> usize {
        self.words.iter().filter(|word| word.contains(char::is_alphanumeric)).count()
    }
}

/// Abbreviations that end with a full stop inside a sentence.
const ABBREVIATIONS: [&str; 19] = [
    "al", "approx", "cf", "ch", "dr", "e.g", "ed", "eq", "eqs", "fig", "figs", "i.e", "no", "p", "pp",
    "resp", "sec", "st", "vs",
];

/// The sentences of a paragraph.
pub(crate) fn sentences(paragraph: &Paragraph) -> Vec<Sentence> {
    let words = words(paragraph);
    let mut sentences = Vec::new();
    let mut open: Option<Sentence> = None;
    for (index, (line, word)) in words.iter().enumerate() {
        let sentence = open.get_or_insert_with(|| Sentence { line: *line, words: Vec::new() });
        sentence.words.push(word.clone());
        if ends_sentence(word, words.get(index + 1).map(|(_, next)| next.as_str())) {
            sentences.extend(open.take());
        }
    }
    sentences.extend(open);
    sentences
}

/// Whether a sentence ends with this word, given the next.
fn ends_sentence(word: &str, next: Option<&str>) -> bool {
    let Some(next) = next else { return true };
    let word = word.trim_end_matches([')', '"', '\'', '”', '’', '*', '_', ']']);
    let begins = next.trim_start_matches(['(', '"', '\'', '“', '*', '_', '[']);
    let is_capital = begins.starts_with(|c: char| c.is_uppercase() || c.is_ascii_digit() || c == '`');
    if let Some(stem) = word.strip_suffix('.') {
        let stem = stem.trim_start_matches(['(', '"', '*', '_', '[']);
        let is_initial = stem.chars().count() == 1 && stem.starts_with(char::is_uppercase) && is_capital;
        let is_ellipsis = stem.ends_with('.');
        let is_abbreviation = ABBREVIATIONS.contains(&stem.to_lowercase().as_str())
            || (stem == "etc" && !is_capital)
            || (is_initial && next.len() > 1 && next.ends_with([',', '.']));
        return !is_abbreviation && (!is_ellipsis || is_capital);
    }
    word.ends_with(['?', '!']) && is_capital
}

/// The words with their lines. Code between backticks is the word `` `code` ``, a formula between dollars is
/// one word, and links are their text.
fn words(paragraph: &Paragraph) -> Vec<(usize, String)> {
    let mut words = Vec::new();
    let (mut word, mut word_line) = (String::new(), 0);
    // The closing mark of the code or formula that a line is in.
    let mut closing: Option<String> = None;
    for &(line, text) in paragraph {
        let mut rest = text;
        while !rest.is_empty() {
            if let Some(close) = &closing {
                let Some(at) = rest.find(close.as_str()) else { break };
                rest = &rest[at + close.len()..];
                closing = None;
                continue;
            }
            let Some(c) = rest.chars().next() else { break };
            if word.is_empty() {
                word_line = line;
            }
            let ticks = rest.bytes().take_while(|&byte| byte == b'`').count();
            if ticks > 0 {
                word.push_str("`code`");
                closing = Some("`".repeat(ticks));
                rest = &rest[ticks..];
            } else if c == '$' && paragraph.iter().any(|(_, text)| text.matches('$').count() > 1) {
                word.push_str("formula");
                closing = Some("$".to_owned());
                rest = rest.trim_start_matches('$');
            } else if rest.starts_with("](") {
                let end = rest.find(')').map_or(rest.len(), |at| at + 1);
                rest = &rest[end..];
            } else if c.is_whitespace() {
                if !word.is_empty() {
                    words.push((word_line, std::mem::take(&mut word)));
                }
                rest = &rest[c.len_utf8()..];
            } else {
                word.push(c);
                rest = &rest[c.len_utf8()..];
            }
        }
        if closing.is_none() && !word.is_empty() {
            words.push((word_line, std::mem::take(&mut word)));
        }
    }
    if !word.is_empty() {
        words.push((word_line, word));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::sentences;

    fn split(text: &str) -> Vec<String> {
        let paragraph = text.lines().enumerate().map(|(index, line)| (index + 1, line)).collect();
        sentences(&paragraph)
            .iter()
            .map(|sentence| format!("{}: {}", sentence.line, sentence.words.join(" ")))
            .collect()
    }

    #[test]
    fn full_stops_end_sentences() {
        assert_eq!(
            split("One 0.5 m. q is two (see x.rs).\nThree! Four? \"Five.\" Six"),
            ["1: One 0.5 m.", "1: q is two (see x.rs).", "2: Three!", "2: Four?", "2: \"Five.\"", "2: Six"]
        );
    }

    #[test]
    fn abbreviations_do_not() {
        assert_eq!(split("See e.g. Fig. 3, W. Khalil, R. M. Murray, etc. and so on ... and on.").len(), 1);
        assert_eq!(split("A body, etc. Another frame A. The next.").len(), 3);
    }

    #[test]
    fn code_and_links_are_words() {
        assert_eq!(
            split("Call `a. B` or ``c`\nd. E`` of [the model. x](y.md) here. $a = b. C$ holds."),
            ["1: Call `code` or `code` of [the model.", "2: x here.", "2: formula holds."]
        );
    }

    #[test]
    fn words_have_letters() {
        let paragraph = vec![(1, "M(q) v̇ + c = τ, 3 words – or 7")];
        assert_eq!(sentences(&paragraph)[0].word_count(), 8);
    }
}
