//! Writes names and texts from a robot's file into each kind of output, with one function for each kind.
//!
//! A name may contain line breaks, control characters of a terminal, marks that change the writing direction,
//! or the end of a cell or an element. All functions here write invisible characters as their escapes, such
//! as `\n` or `\u{202e}`. These are the general categories Cc, Cf, Zl, Zp, Co, Cn and Zs, except the space.
//! Letters, marks, numbers, punctuation and symbols stay. A text without anything to escape is returned
//! unchanged.

use core::fmt::Write;
use std::borrow::Cow;

/// Whether a character is visible, by Unicode's general category.
fn is_visible(letter: char) -> bool {
    if letter.is_ascii() {
        return !letter.is_ascii_control();
    }
    // Uses the standard library's table of printable characters. It also escapes combining marks, unless they
    // follow a letter.
    let mut pair = [b'a', 0, 0, 0, 0];
    let length = 1 + letter.encode_utf8(&mut pair[1..]).len();
    core::str::from_utf8(&pair[..length]).is_ok_and(|pair| pair.escape_debug().nth(1) == Some(letter))
}

fn with_each(text: &str, stays: impl Fn(char) -> bool, write: impl Fn(&mut String, char)) -> Cow<'_, str> {
    if text.chars().all(&stays) {
        return Cow::Borrowed(text);
    }
    let mut written = String::with_capacity(text.len() + 16);
    for letter in text.chars() {
        if stays(letter) { written.push(letter) } else { write(&mut written, letter) }
    }
    Cow::Owned(written)
}

fn escape(written: &mut String, letter: char) {
    written.extend(letter.escape_debug());
}

/// A text on one line of a terminal, a report or a log.
///
/// ```
/// use robot_dynamics::text::one_line;
/// assert_eq!(one_line("bras supérieur №2"), "bras supérieur №2");
/// assert_eq!(one_line("el\nbow\u{1b}[2J\u{202e}"), r"el\nbow\u{1b}[2J\u{202e}");
/// ```
pub fn one_line(text: &str) -> Cow<'_, str> {
    with_each(text, is_visible, escape)
}

/// A text of several lines, each as [`one_line`]. Names in it must already have been escaped.
///
/// ```
/// assert_eq!(robot_dynamics::text::lines("two\nlines\u{9b}1m\n"), "two\nlines\\u{9b}1m\n");
/// ```
pub fn lines(text: &str) -> Cow<'_, str> {
    with_each(text, |letter| letter == '\n' || is_visible(letter), escape)
}

/// A text within running text, a heading or a table cell of Markdown, not at the beginning of a line. Nothing
/// in it is markup, and GitHub makes no link of an address in it.
///
/// ```
/// use robot_dynamics::text::markdown;
/// assert_eq!(markdown("left_arm: frame (2)"), "left_arm: frame (2)");
/// assert_eq!(markdown("a|b_ <b>\n"), r"a\|b\_ \<b\>\\n");
/// ```
pub fn markdown(text: &str) -> Cow<'_, str> {
    let seen = one_line(text);
    let letters: Vec<char> = seen.chars().collect();
    let is_word = |at: usize| letters.get(at).is_some_and(|letter| letter.is_alphanumeric());
    let is_markup = |at: usize| match letters[at] {
        '_' => !(at > 0 && is_word(at - 1) && is_word(at + 1)),
        ':' => letters.get(at + 1) == Some(&'/'),
        '.' => at > 0 && letters[at - 1].eq_ignore_ascii_case(&'w'),
        '/' | ',' | ';' | '%' | '\'' | '"' | '?' | '(' | ')' | '=' | '-' | '+' => false,
        other => other.is_ascii_punctuation(),
    };
    if !(0..letters.len()).any(is_markup) {
        return seen;
    }
    let mut written = String::with_capacity(seen.len() + 8);
    for (at, letter) in letters.iter().enumerate() {
        if is_markup(at) {
            written.push('\\');
        }
        written.push(*letter);
    }
    Cow::Owned(written)
}

/// A text as inline code of Markdown, with its backticks, also in a table cell.
///
/// ```
/// use robot_dynamics::text::markdown_code;
/// assert_eq!(markdown_code("hinge"), "`hinge`");
/// assert_eq!(markdown_code("a`b|c"), r"``a`b\|c``");
/// ```
pub fn markdown_code(text: &str) -> String {
    let text = one_line(text).replace('|', "\\|");
    let (mut longest, mut run) = (0, 0);
    for letter in text.chars() {
        run = if letter == '`' { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let fence = "`".repeat(longest + 1);
    // Markdown strips one space from both sides. Without these spaces it would strip a space, or join a
    // backtick, at an end.
    let is_bare = |letter: char| letter == '`' || letter == ' ';
    let pad = if text.is_empty() || text.starts_with(is_bare) || text.ends_with(is_bare) { " " } else { "" };
    format!("{fence}{pad}{text}{pad}{fence}")
}

/// A text as a cell of comma-separated values (RFC 4180), on one line.
///
/// ```
/// use robot_dynamics::text::csv_cell;
/// assert_eq!(csv_cell("q elbow [rad]"), "q elbow [rad]");
/// assert_eq!(csv_cell("a,\"b\"\n"), r#""a,""b""\n""#);
/// ```
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    let text = one_line(text);
    if text.contains([',', '"']) { Cow::Owned(format!("\"{}\"", text.replace('"', "\"\""))) } else { text }
}

/// A text between tags or within an attribute of XML, SVG or HTML.
///
/// ```
/// assert_eq!(robot_dynamics::text::xml("a<b> & 'c'\u{1}"), r"a&lt;b&gt; &amp; &#39;c&#39;\u{1}");
/// ```
pub fn xml(text: &str) -> Cow<'_, str> {
    let is_markup = |letter: char| matches!(letter, '<' | '>' | '&' | '"' | '\'');
    with_each(
        text,
        |letter| is_visible(letter) && !is_markup(letter),
        |written, letter| match letter {
            '<' => written.push_str("&lt;"),
            '>' => written.push_str("&gt;"),
            '&' => written.push_str("&amp;"),
            '"' => written.push_str("&quot;"),
            '\'' => written.push_str("&#39;"),
            other => escape(written, other),
        },
    )
}

/// A text as a file name without extension, valid on any system. Letters, digits, `-` and `_` stay, all other
/// characters become `_`; at most 80 characters.
///
/// ```
/// use robot_dynamics::text::file_stem;
/// assert_eq!(file_stem("bras_supérieur-2"), "bras_supérieur-2");
/// assert_eq!(file_stem("../a:b\u{202e}\n"), "___a_b__");
/// assert_eq!(file_stem(""), "_");
/// ```
pub fn file_stem(text: &str) -> String {
    const LONGEST: usize = 80;
    let stays = |letter: char| letter.is_alphanumeric() || matches!(letter, '-' | '_');
    let stem: String =
        text.chars().take(LONGEST).map(|letter| if stays(letter) { letter } else { '_' }).collect();
    if stem.is_empty() { "_".to_owned() } else { stem }
}

/// JSON text with invisible characters as JSON's escapes. The values stay the same.
///
/// ```
/// let line = "{\"name\":\"a\u{202e}\u{9b}\u{e0001}\"}\n";
/// assert_eq!(robot_dynamics::text::json(line), "{\"name\":\"a\\u202e\\u009b\\udb40\\udc01\"}\n");
/// ```
pub fn json(text: &str) -> Cow<'_, str> {
    // Such characters occur only in strings, except for line ends.
    with_each(
        text,
        |letter| matches!(letter, '\n' | '\t' | '\r') || is_visible(letter),
        |written, letter| {
            for unit in letter.encode_utf16(&mut [0; 2]) {
                let _ = write!(written, "\\u{unit:04x}");
            }
        },
    )
}
