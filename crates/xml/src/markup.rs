//! Corrects markup that XML does not allow and that other readers of robot files accept.
//!
//! - `--` in a comment.
//! - No space between two attributes.
//! - `&` that is not the start of a reference, and `<` in an attribute's value: taken as these characters.
//! - Control characters: taken as spaces.
//!
//! The line numbers stay the same.

/// A kind of incorrect markup.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Comment,
    Space,
    Ampersand,
    LessThan,
    Control,
}

impl Kind {
    const fn message(self) -> &'static str {
        match self {
            Self::Comment => "`--` inside a comment, or `-` at its end, is not XML: read as a comment",
            Self::Space => "there is no space between two attributes: read as two attributes; insert it",
            Self::Ampersand => "`&` is not the start of a reference: read as the character; write `&amp;`",
            Self::LessThan => {
                "`<` in the value of an attribute is not XML: read as the character; write `&lt;`"
            }
            Self::Control => "control characters are not XML: read as spaces; delete them",
        }
    }
}

/// The corrected text, and the line and message of the first fault of each kind.
pub(crate) fn correct(text: &str) -> (String, Vec<(usize, String)>) {
    let mut corrected =
        Corrected { original: text, text: String::with_capacity(text.len()), faults: Vec::new() };
    let mut at = 0;
    while let Some(found) = text[at..].find('<') {
        let start = at + found;
        corrected.push_text(at, start, false);
        at = corrected.push_markup(start);
    }
    corrected.push_text(at, text.len(), false);
    let line_of = |at: usize| 1 + text[..at].matches('\n').count();
    let message = |kind: Kind, count: usize| match count {
        1 => kind.message().to_owned(),
        _ => format!("{} ({count} times in this file)", kind.message()),
    };
    let faults = corrected.faults.iter().map(|&(kind, first, count)| (line_of(first), message(kind, count)));
    let faults = faults.collect();
    (corrected.text, faults)
}

struct Corrected<'a> {
    original: &'a str,
    text: String,
    /// Each kind with the byte of its first fault, and the number of faults.
    faults: Vec<(Kind, usize, usize)>,
}

impl Corrected<'_> {
    fn add_fault(&mut self, kind: Kind, at: usize) {
        match self.faults.iter_mut().find(|fault| fault.0 == kind) {
            Some(fault) => fault.2 += 1,
            None => self.faults.push((kind, at, 1)),
        }
    }

    /// Copies characters; in a value `<` is a fault, elsewhere it does not occur.
    fn push_text(&mut self, start: usize, end: usize, in_value: bool) {
        for (offset, letter) in self.original[start..end].char_indices() {
            let at = start + offset;
            match letter {
                '&' if !is_reference(&self.original[at..end]) => {
                    self.add_fault(Kind::Ampersand, at);
                    self.text.push_str("&amp;");
                }
                '<' if in_value => {
                    self.add_fault(Kind::LessThan, at);
                    self.text.push_str("&lt;");
                }
                _ => self.push_letter(letter, at),
            }
        }
    }

    fn push_letter(&mut self, letter: char, at: usize) {
        let is_xml = matches!(letter, '\t' | '\n' | '\r')
            || (letter >= ' ' && !matches!(letter, '\u{fffe}' | '\u{ffff}'));
        if !is_xml {
            self.add_fault(Kind::Control, at);
        }
        self.text.push(if is_xml { letter } else { ' ' });
    }

    /// Copies what begins with this `<`; returns its end.
    fn push_markup(&mut self, start: usize) -> usize {
        let rest = &self.original[start..];
        let end_after =
            |mark: &str| rest.find(mark).map_or(self.original.len(), |at| start + at + mark.len());
        if let Some(comment) = rest.strip_prefix("<!--") {
            let Some(length) = comment.find("-->") else {
                self.text.push_str(rest);
                return self.original.len();
            };
            self.push_comment(start + 4, start + 4 + length);
            return start + 4 + length + 3;
        }
        let end = match rest {
            _ if rest.starts_with("<![CDATA[") => end_after("]]>"),
            _ if rest.starts_with("<?") => end_after("?>"),
            _ if rest.starts_with("<!") || rest.starts_with("</") => end_after(">"),
            _ => return self.push_tag(start),
        };
        self.text.push_str(&self.original[start..end]);
        end
    }

    /// Writes a comment with this content; `=` replaces its dashes if they are not XML.
    fn push_comment(&mut self, start: usize, end: usize) {
        let content = &self.original[start..end];
        let is_faulty = content.contains("--") || content.ends_with('-');
        if is_faulty {
            self.add_fault(Kind::Comment, start);
        }
        self.text.push_str("<!--");
        for (offset, letter) in content.char_indices() {
            self.push_letter(if is_faulty && letter == '-' { '=' } else { letter }, start + offset);
        }
        self.text.push_str("-->");
    }

    /// Copies an opening or empty tag with its attributes; returns its end.
    fn push_tag(&mut self, start: usize) -> usize {
        let bytes = self.original.as_bytes();
        let mut at = start;
        while let Some(length) = bytes[at..].iter().position(|byte| b"\"'>".contains(byte)) {
            self.text.push_str(&self.original[at..at + length]);
            at += length;
            let mark = bytes[at];
            self.text.push(char::from(mark));
            at += 1;
            if mark == b'>' {
                return at;
            }
            let Some(length) = bytes[at..].iter().position(|&byte| byte == mark) else { break };
            self.push_text(at, at + length, true);
            self.text.push(char::from(mark));
            at += length + 1;
            if bytes.get(at).is_some_and(|&next| !next.is_ascii_whitespace() && !b"/>".contains(&next)) {
                self.add_fault(Kind::Space, at);
                self.text.push(' ');
            }
        }
        self.text.push_str(&self.original[at..]);
        self.original.len()
    }
}

/// Whether a text begins with a reference to a character, such as `&lt;` or `&#65;`.
fn is_reference(text: &str) -> bool {
    let Some((name, _)) = text[1..].split_once(';') else { return false };
    let is_code = |digits: &str, radix: u32| {
        u32::from_str_radix(digits, radix).is_ok_and(|code| char::from_u32(code).is_some())
    };
    match name.strip_prefix('#') {
        Some(code) => code.strip_prefix('x').map_or_else(|| is_code(code, 10), |code| is_code(code, 16)),
        None => ["amp", "lt", "gt", "quot", "apos"].contains(&name),
    }
}

#[cfg(test)]
mod tests {
    use roxmltree::Document;

    use super::correct;

    #[test]
    fn correct_markup_is_unchanged() {
        let text =
            "<?xml version='1.0'?>\n<!-- a - b --><a b='1' c=\"&lt;&#65;'\"><![CDATA[&<--]]>&amp;<d/></a>";
        assert_eq!(correct(text), (text.to_owned(), Vec::new()));
    }

    #[test]
    fn incorrect_markup_has_its_evident_meaning() {
        let text = "<!------- rule -------><!--- end ---><a\nb='1'c=\"<&x;&\"/>";
        let (corrected, faults) = correct(text);
        let document = Document::parse(&corrected).expect("XML");
        let root = document.root_element();
        assert_eq!((root.attribute("b"), root.attribute("c")), (Some("1"), Some("<&x;&")));
        let found: Vec<(usize, bool)> =
            faults.iter().map(|(line, message)| (*line, message.contains("2 times"))).collect();
        // Comments, `<`, two `&`, and the space.
        assert_eq!(found, [(1, true), (2, false), (2, false), (2, true)]);
        let (corrected, faults) = correct("<a b='\u{1}é'>\u{b}</a>");
        assert_eq!((corrected.as_str(), faults.len()), ("<a b=' é'> </a>", 1));
    }

    /// Text without an end is copied, for the parser to report.
    #[test]
    fn incomplete_text_is_unchanged() {
        for text in ["<a b='1", "<!-- a", "<a", "<", "<a b='é", "<?x", "</a", "<![CDATA[", "<!-"] {
            assert_eq!(correct(text), (text.to_owned(), Vec::new()));
        }
    }
}
