//! The longest functions.

use super::rust_file::RustFile;
use crate::tokens::{Token, after_group, line_of, tokenize};

/// A function.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Function {
    /// Its file.
    pub(super) path: String,
    /// Its name.
    pub(super) name: String,
    /// Its first line, from 1.
    pub(super) line: usize,
    /// Its lines, from `fn` to its last brace.
    pub(super) lines: usize,
}

/// How many are listed.
const LISTED: usize = 10;

/// The longest functions of sources, tests not counted.
pub(super) fn longest(rust: &[RustFile]) -> Vec<Function> {
    let sources = rust.iter().filter(|file| !file.is_test);
    let mut found: Vec<Function> = sources.flat_map(|file| functions(file.path, &file.code)).collect();
    found.sort_by_key(|function| std::cmp::Reverse(function.lines));
    found.truncate(LISTED);
    found
}

fn functions(path: &str, code: &str) -> Vec<Function> {
    let tokens = tokenize(code);
    let mut found = Vec::new();
    for (index, placed) in tokens.iter().enumerate() {
        let (Token::Word("fn"), Some(Token::Word(name))) =
            (placed.token, tokens.get(index + 1).map(|next| next.token))
        else {
            continue;
        };
        let mut at = index + 2;
        while at < tokens.len() {
            match tokens[at].token {
                Token::Mark(b'(' | b'[') => at = after_group(&tokens, at),
                Token::Mark(b';' | b'}') => break,
                Token::Mark(b'{') => {
                    let end = after_group(&tokens, at) - 1;
                    let line = line_of(code, placed.at);
                    let lines = 1 + line_of(code, tokens[end].at) - line;
                    found.push(Function { path: path.to_owned(), name: name.to_owned(), line, lines });
                    break;
                }
                _ => at += 1,
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::functions;

    #[test]
    fn functions_have_their_lines() {
        let found =
            functions("a.rs", "trait T { fn a(x: [u8; 3]); }\nfn b()\nwhere X: Y\n{\n    fn c() {}\n}\n");
        let shown: Vec<(&str, usize, usize)> =
            found.iter().map(|one| (one.name.as_str(), one.line, one.lines)).collect();
        assert_eq!(shown, [("b", 2, 5), ("c", 5, 1)]);
    }
}
