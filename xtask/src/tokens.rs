//! The tokens of Rust code, and code without its unit tests.

use crate::files::Language;
use crate::lexer::{blank, is_word, lex};

/// A token of Rust.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Token<'a> {
    /// An identifier or keyword; `r#` is left out.
    Word(&'a str),
    /// `::`
    Path,
    /// A literal or a lifetime.
    Other,
    /// A character of punctuation.
    Mark(u8),
}

/// A token and its first byte.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    /// The token.
    pub(crate) token: Token<'a>,
    /// Its first byte.
    pub(crate) at: usize,
}

/// A Rust source with blanks for comments and for what literals hold, and the same with blanks for unit tests
/// too.
pub(crate) fn code(text: &str) -> (String, String) {
    let code = blank(text, &lex(text, Language::Rust));
    let tested = without_tests(&code);
    (code, tested)
}

/// The tokens of blanked code.
pub(crate) fn tokenize(code: &str) -> Vec<Placed<'_>> {
    let bytes = code.as_bytes();
    let (mut tokens, mut at) = (Vec::with_capacity(bytes.len() / 5), 0);
    while at < bytes.len() {
        let start = at;
        let byte = bytes[at];
        let token = if byte.is_ascii_whitespace() {
            at += 1;
            continue;
        } else if byte.is_ascii_digit() {
            at += 1;
            while at < bytes.len()
                && (is_word(bytes[at])
                    || (bytes[at] == b'.' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit)))
            {
                at += 1;
            }
            Token::Other
        } else if is_word(byte) {
            if bytes[at..].starts_with(b"r#") {
                at += 2;
            }
            let from = at;
            while at < bytes.len() && is_word(bytes[at]) {
                at += 1;
            }
            Token::Word(&code[from..at])
        } else if byte == b'"' {
            // Nothing is left in a literal but blanks.
            at = bytes[at + 1..].iter().position(|&b| b == b'"').map_or(bytes.len(), |n| at + n + 2);
            Token::Other
        } else if byte == b'\'' {
            at += 1;
            while at < bytes.len() && is_word(bytes[at]) {
                at += 1;
            }
            Token::Other
        } else if bytes[at..].starts_with(b"::") {
            at += 2;
            Token::Path
        } else {
            at += 1;
            Token::Mark(byte)
        };
        tokens.push(Placed { token, at: start });
    }
    tokens
}

/// The index after the group that opens at `open`, one of `(`, `[`, `{`.
pub(crate) fn after_group(tokens: &[Placed], open: usize) -> usize {
    let mut depth = 0_usize;
    for (index, placed) in tokens.iter().enumerate().skip(open) {
        match placed.token {
            Token::Mark(b'(' | b'[' | b'{') => depth += 1,
            Token::Mark(b')' | b']' | b'}') => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return index + 1;
                }
            }
            _ => {}
        }
    }
    tokens.len()
}

/// The index after an item that begins at `start`: after its block, or its `;`.
pub(crate) fn after_item(tokens: &[Placed], start: usize) -> usize {
    let mut index = start;
    while index < tokens.len() {
        match tokens[index].token {
            Token::Mark(b'{') => return after_group(tokens, index),
            Token::Mark(b'(' | b'[') => index = after_group(tokens, index),
            Token::Mark(b';') => return index + 1,
            // A field, a variant or a statement ends where its list ends.
            Token::Mark(b')' | b']' | b'}') => return index,
            _ => index += 1,
        }
    }
    index
}

/// Blanks in place of items under `#[cfg(test)]` and the like.
fn without_tests(code: &str) -> String {
    if !code.contains("test)") && !code.contains("test,") {
        return code.to_owned();
    }
    let tokens = tokenize(code);
    let mut bytes = code.as_bytes().to_vec();
    let mut index = 0;
    while index + 1 < tokens.len() {
        let is_inner = tokens[index + 1].token == Token::Mark(b'!');
        let open = index + 1 + usize::from(is_inner);
        if tokens[index].token != Token::Mark(b'#')
            || tokens.get(open).map(|placed| placed.token) != Some(Token::Mark(b'['))
        {
            index += 1;
            continue;
        }
        let mut end = after_group(&tokens, open);
        if !is_for_tests(&tokens[open + 1..end]) {
            index = end;
            continue;
        }
        if is_inner {
            end = tokens.len();
        } else {
            while tokens.get(end).map(|placed| placed.token) == Some(Token::Mark(b'#')) {
                end = after_group(&tokens, end + 1);
            }
            end = after_item(&tokens, end);
        }
        let to = tokens.get(end).map_or(bytes.len(), |placed| placed.at);
        for byte in &mut bytes[tokens[index].at..to] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        index = end;
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Whether an attribute is `cfg(test)`, `cfg(all(test, …))` or `cfg(doctest)`.
fn is_for_tests(attribute: &[Placed]) -> bool {
    let words: Vec<&str> = attribute
        .iter()
        .filter_map(|placed| match placed.token {
            Token::Word(word) => Some(word),
            _ => None,
        })
        .take(3)
        .collect();
    matches!(words.as_slice(), ["cfg", "test" | "doctest", ..] | ["cfg", "all", "test"])
}

/// The line of a byte, from 1.
pub(crate) fn line_of(text: &str, at: usize) -> usize {
    1 + text[..at].matches('\n').count()
}

#[cfg(test)]
mod tests {
    use super::{Token, code, line_of, tokenize};

    #[test]
    fn words_paths_and_numbers_are_told_apart() {
        let found: Vec<Token> = tokenize("r#a::b(0..1.5e3, 'c, \"  \")").iter().map(|p| p.token).collect();
        let expected = [
            Token::Word("a"),
            Token::Path,
            Token::Word("b"),
            Token::Mark(b'('),
            Token::Other,
            Token::Mark(b'.'),
            Token::Mark(b'.'),
            Token::Other,
            Token::Mark(b','),
            Token::Other,
            Token::Mark(b','),
            Token::Other,
            Token::Mark(b')'),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn unit_tests_are_left_out() {
        let text = "use a;\n#[cfg(test)]\nuse b::{c, d};\nfn e() {}\n#[cfg(test)]\n#[allow(x)]\nmod tests { fn f() {} }\nfn g() {}";
        let (_, tested) = code(text);
        assert_eq!(tested.split_whitespace().collect::<Vec<_>>().join(" "), "use a; ; fn e() {} fn g() {}");
        assert_eq!(tested.lines().count(), text.lines().count());
    }

    #[test]
    fn lines_count_from_one() {
        assert_eq!((line_of("a\nb", 0), line_of("a\nb", 2)), (1, 2));
    }
}
