//! Where a source file has comments, text literals and code.

use crate::files::Language;

/// The kind of a part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Code, blanks included.
    Code,
    /// A comment.
    Comment,
    /// A comment that documents an item, or a docstring.
    Doc,
    /// A string or character literal with its quotes.
    Literal,
}

/// A part of a file: bytes `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Its kind.
    pub(crate) kind: Kind,
    /// Its first byte.
    pub(crate) start: usize,
    /// The byte after its last.
    pub(crate) end: usize,
}

/// The parts of a file in order, without gaps. Markdown is one comment that documents.
pub(crate) fn lex(text: &str, language: Language) -> Vec<Span> {
    let mut lexer = Lexer { bytes: text.as_bytes(), text, at: 0, code_from: 0, spans: Vec::new() };
    match language {
        Language::Markdown => lexer.spans.push(Span { kind: Kind::Doc, start: 0, end: text.len() }),
        Language::Rust => lexer.run(Lexer::rust),
        Language::Script => lexer.run(Lexer::script),
        Language::Python => lexer.run(Lexer::python),
        Language::Settings => lexer.run(Lexer::settings),
    }
    lexer.spans
}

/// The text with blanks in place of comments and of what literals hold; lines and columns stay.
pub(crate) fn blank(text: &str, spans: &[Span]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for span in spans.iter().filter(|span| span.kind != Kind::Code) {
        for byte in &mut bytes[span.start..span.end] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        if span.kind == Kind::Literal {
            bytes[span.start] = b'"';
            bytes[span.end - 1] = b'"';
        }
    }
    // Whole characters were replaced by ASCII.
    String::from_utf8_lossy(&bytes).into_owned()
}

struct Lexer<'a> {
    bytes: &'a [u8],
    text: &'a str,
    at: usize,
    code_from: usize,
    spans: Vec<Span>,
}

impl Lexer<'_> {
    /// Repeats a step until the end. A step returns the kind and the end of what begins at `at`, or nothing
    /// for code.
    fn run(&mut self, step: fn(&Self) -> Option<(Kind, usize)>) {
        while self.at < self.bytes.len() {
            if let Some((kind, end)) = step(self) {
                let end = end.min(self.bytes.len());
                self.flush();
                self.spans.push(Span { kind, start: self.at, end });
                (self.at, self.code_from) = (end, end);
            } else {
                self.at += 1;
            }
        }
        self.flush();
    }

    fn flush(&mut self) {
        if self.code_from < self.at {
            self.spans.push(Span { kind: Kind::Code, start: self.code_from, end: self.at });
        }
    }

    fn starts(&self, prefix: &str) -> bool {
        self.bytes[self.at..].starts_with(prefix.as_bytes())
    }

    fn end_of_line(&self) -> usize {
        self.bytes[self.at..].iter().position(|&byte| byte == b'\n').map_or(self.bytes.len(), |n| self.at + n)
    }

    /// The end of a literal that opened with `open` bytes: after `close`, a backslash escapes.
    fn end_of_literal(&self, open: usize, close: &str) -> usize {
        let mut at = self.at + open;
        while at < self.bytes.len() {
            if self.bytes[at] == b'\\' {
                at += 2;
            } else if self.bytes[at..].starts_with(close.as_bytes()) {
                return at + close.len();
            } else {
                at += 1;
            }
        }
        self.bytes.len()
    }

    /// Whether an identifier ends right before `at`.
    fn follows_word(&self) -> bool {
        self.at > 0 && is_word(self.bytes[self.at - 1])
    }

    fn rust(&self) -> Option<(Kind, usize)> {
        match self.bytes[self.at] {
            b'/' if self.starts("//") => {
                let is_doc = (self.starts("///") && !self.starts("////")) || self.starts("//!");
                Some((if is_doc { Kind::Doc } else { Kind::Comment }, self.end_of_line()))
            }
            b'/' if self.starts("/*") => {
                let is_doc = (self.starts("/**") && !self.starts("/***") && !self.starts("/**/"))
                    || self.starts("/*!");
                Some((if is_doc { Kind::Doc } else { Kind::Comment }, self.end_of_nested_comment()))
            }
            b'"' => Some((Kind::Literal, self.end_of_literal(1, "\""))),
            b'r' | b'b' | b'c' if !self.follows_word() => self.raw_string(),
            b'\'' => self.character(),
            _ => None,
        }
    }

    fn end_of_nested_comment(&self) -> usize {
        let (mut depth, mut at) = (0_usize, self.at);
        while at + 1 < self.bytes.len() {
            match &self.bytes[at..at + 2] {
                b"/*" => {
                    depth += 1;
                    at += 2;
                }
                b"*/" => {
                    depth -= 1;
                    at += 2;
                    if depth == 0 {
                        return at;
                    }
                }
                _ => at += 1,
            }
        }
        self.bytes.len()
    }

    /// `r"…"`, `r#"…"#` and their kin with `b` or `c` before.
    fn raw_string(&self) -> Option<(Kind, usize)> {
        let rest = &self.bytes[self.at..];
        let prefix = rest.iter().take_while(|byte| matches!(byte, b'r' | b'b' | b'c')).count();
        if !rest[..prefix].ends_with(b"r") || prefix > 2 {
            return None;
        }
        let hashes = rest[prefix..].iter().take_while(|&&byte| byte == b'#').count();
        if rest.get(prefix + hashes) != Some(&b'"') {
            return None;
        }
        let close = format!("\"{}", "#".repeat(hashes));
        let from = self.at + prefix + hashes + 1;
        let end = self.text[from..].find(&close).map_or(self.bytes.len(), |n| from + n + close.len());
        Some((Kind::Literal, end))
    }

    /// A character literal; a lifetime is code.
    fn character(&self) -> Option<(Kind, usize)> {
        let mut following = self.text[self.at + 1..].char_indices();
        let (_, first) = following.next()?;
        if first == '\\' {
            return Some((Kind::Literal, self.end_of_literal(1, "'")));
        }
        match following.next() {
            Some((offset, '\'')) => Some((Kind::Literal, self.at + 1 + offset + 1)),
            _ => None,
        }
    }

    fn script(&self) -> Option<(Kind, usize)> {
        match self.bytes[self.at] {
            b'/' if self.starts("//") => Some((Kind::Comment, self.end_of_line())),
            b'/' if self.starts("/*") => {
                let kind = if self.starts("/**") { Kind::Doc } else { Kind::Comment };
                let end = self.text[self.at + 2..].find("*/");
                Some((kind, end.map_or(self.bytes.len(), |n| self.at + n + 4)))
            }
            b'/' if self.may_begin_pattern() => Some((Kind::Literal, self.end_of_pattern()?)),
            b'"' => Some((Kind::Literal, self.end_of_literal(1, "\""))),
            b'\'' => Some((Kind::Literal, self.end_of_literal(1, "'"))),
            b'`' => Some((Kind::Literal, self.end_of_template(self.at))),
            _ => None,
        }
    }

    /// Whether a `/` here begins a regular expression and does not divide.
    fn may_begin_pattern(&self) -> bool {
        let before = self.bytes[..self.at].trim_ascii_end();
        before.last().is_none_or(|byte| b"(,=:[!&|?{};+".contains(byte)) || before.ends_with(b"return")
    }

    fn end_of_pattern(&self) -> Option<usize> {
        let (mut at, mut in_class) = (self.at + 1, false);
        while at < self.bytes.len() && self.bytes[at] != b'\n' {
            match self.bytes[at] {
                b'\\' => at += 1,
                b'[' => in_class = true,
                b']' => in_class = false,
                b'/' if !in_class => return Some(at + 1),
                _ => {}
            }
            at += 1;
        }
        None
    }

    /// The end of a template literal that begins at `from`; its `${…}` may hold others.
    fn end_of_template(&self, from: usize) -> usize {
        let (mut at, mut depth) = (from + 1, 0_usize);
        while at < self.bytes.len() {
            match self.bytes[at] {
                b'\\' => at += 1,
                b'`' if depth == 0 => return at + 1,
                b'`' => at = self.end_of_template(at) - 1,
                b'{' if depth > 0 || self.bytes[at - 1] == b'$' => depth += 1,
                b'}' if depth > 0 => depth -= 1,
                _ => {}
            }
            at += 1;
        }
        self.bytes.len()
    }

    fn python(&self) -> Option<(Kind, usize)> {
        match self.bytes[self.at] {
            b'#' => Some((Kind::Comment, self.end_of_line())),
            b'"' | b'\'' => {
                let quote = if self.starts("\"\"\"") {
                    "\"\"\""
                } else if self.starts("'''") {
                    "'''"
                } else if self.starts("\"") {
                    "\""
                } else {
                    "'"
                };
                // A string that begins a line of three quotes is a docstring; a prefix `r` may stand before
                // it.
                let line = self.bytes[..self.at].rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
                let is_doc = quote.len() == 3 && matches!(line.trim_ascii(), b"" | b"r");
                let kind = if is_doc { Kind::Doc } else { Kind::Literal };
                Some((kind, self.end_of_literal(quote.len(), quote)))
            }
            _ => None,
        }
    }

    fn settings(&self) -> Option<(Kind, usize)> {
        let line = self.bytes[..self.at].rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
        let is_comment = self.bytes[self.at] == b'#' && line.trim_ascii().is_empty();
        is_comment.then(|| (Kind::Comment, self.end_of_line()))
    }
}

/// Whether a byte may be part of an identifier; letters beyond ASCII may.
pub(crate) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

#[cfg(test)]
mod tests {
    use super::{Kind, blank, lex};
    use crate::files::Language;

    fn parts(text: &str, language: Language, kind: Kind) -> Vec<&str> {
        let spans = lex(text, language);
        assert_eq!(spans.iter().map(|span| &text[span.start..span.end]).collect::<String>(), text);
        spans.iter().filter(|span| span.kind == kind).map(|span| &text[span.start..span.end]).collect()
    }

    #[test]
    fn comments_of_rust_are_found() {
        let text = "//! A.\n/// B.\nfn f() { /* c /* d */ */ } //// e\n// f";
        assert_eq!(parts(text, Language::Rust, Kind::Doc), ["//! A.", "/// B."]);
        assert_eq!(parts(text, Language::Rust, Kind::Comment), ["/* c /* d */ */", "//// e", "// f"]);
    }

    #[test]
    fn literals_of_rust_hold_no_comments() {
        let text = r##"("// a", '"', b'\'', r#"" // b"#, br"\", "\"//", 'λ') // c"##;
        assert_eq!(parts(text, Language::Rust, Kind::Comment), ["// c"]);
        assert_eq!(parts(text, Language::Rust, Kind::Literal).len(), 7);
    }

    #[test]
    fn lifetimes_and_raw_names_are_code() {
        assert!(parts("fn f<'a>(r#type: &'a str, b: &'_ u8)", Language::Rust, Kind::Literal).is_empty());
    }

    #[test]
    fn blanking_keeps_lines_and_columns() {
        let text = "let a = \"λ\n{\"; // }\nb";
        assert_eq!(blank(text, &lex(text, Language::Rust)), "let a = \"  \n \";     \nb");
    }

    #[test]
    fn docstrings_of_python_are_documentation() {
        let text =
            "def f():\n    \"\"\"It's # one.\"\"\"\n    x = '# two'  # three\n    y = \"\"\"four\"\"\"\n";
        assert_eq!(parts(text, Language::Python, Kind::Doc), ["\"\"\"It's # one.\"\"\""]);
        assert_eq!(parts(text, Language::Python, Kind::Comment), ["# three"]);
    }

    #[test]
    fn templates_and_patterns_of_scripts_are_literals() {
        let text = "const a = /[/\"]\\//g; b = `x ${c ? `//` : {}} '`; d = e / 2; // f";
        assert_eq!(parts(text, Language::Script, Kind::Comment), ["// f"]);
        assert_eq!(parts(text, Language::Script, Kind::Literal).len(), 2);
    }

    #[test]
    fn settings_have_comments_on_their_own_lines() {
        assert_eq!(parts("# a\nb = \"#c\" # d\n  # e\n", Language::Settings, Kind::Comment), ["# a", "# e"]);
    }
}
