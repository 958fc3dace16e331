//! Tests how names are written into outputs, for every general category of Unicode, with readers that are
//! independent of the writer.

use robot_dynamics::text::{csv_cell, json, lines, markdown, markdown_code, one_line, xml};

/// Characters of each of the 30 general categories of the Unicode Character Database (17.0), and whether they
/// are visible. Surrogates (Cs) are not characters in Rust.
const CATEGORIES: [(&str, &str, bool); 29] = [
    ("Cc", "\u{0}\u{7}\t\n\u{b}\u{c}\r\u{1b}\u{7f}\u{80}\u{85}\u{9b}\u{9d}\u{9f}", false),
    (
        "Cf",
        "\u{ad}\u{600}\u{61c}\u{70f}\u{180e}\u{200b}\u{200c}\u{200d}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\
         \u{2060}\u{2064}\u{2066}\u{2067}\u{2068}\u{2069}\u{206a}\u{feff}\u{fff9}\u{1bca0}\u{1d173}\u{e0001}\u{e0041}",
        false,
    ),
    ("Cn", "\u{378}\u{fdd0}\u{fffe}\u{ffff}\u{1ffff}\u{10ffff}", false),
    ("Co", "\u{e000}\u{f8ff}\u{f0000}\u{10fffd}", false),
    ("Zl", "\u{2028}", false),
    ("Zp", "\u{2029}", false),
    ("Zs", "\u{a0}\u{1680}\u{2000}\u{2009}\u{202f}\u{205f}\u{3000}", false),
    ("Ll", "azßéжλ\u{1d4d0}", true),
    ("Lm", "ʰːๆ々", true),
    ("Lo", "ªאعकあ漢한", true),
    ("Lt", "ǅᾈ", true),
    ("Lu", "AZÄЖΛ", true),
    ("Mc", "\u{903}\u{93e}\u{bbe}", true),
    ("Me", "\u{488}\u{20dd}", true),
    ("Mn", "\u{300}\u{301}\u{591}\u{94d}\u{fe0f}", true),
    ("Nd", "09٣५", true),
    ("Nl", "Ⅷ〇𐅀", true),
    ("No", "²½①", true),
    ("Pc", "_‿﹏", true),
    ("Pd", "-–—〜", true),
    ("Pe", ")]}》", true),
    ("Pf", "»’”", true),
    ("Pi", "«‘“", true),
    ("Po", "!\"#%&'*,./:;?@\\¡§。", true),
    ("Ps", "([{《", true),
    ("Sc", "$€₿", true),
    ("Sk", "^`¨˜", true),
    ("Sm", "+<=>|~±∑", true),
    ("So", "©°№🦾", true),
];

fn texts() -> impl Iterator<Item = String> {
    let of_category = CATEGORIES.into_iter().flat_map(|(_, letters, _)| {
        letters.chars().map(|letter| format!("a{letter}b")).chain([letters.to_owned()])
    });
    of_category.chain(
        ["", " ", "plain name", "a\u{301}", "\u{301}", "```", "`", "a|b|", "\"\"", ",", "&lt;"]
            .map(str::to_owned),
    )
}

#[test]
fn each_category_is_seen_or_escaped() {
    for (category, letters, is_seen) in CATEGORIES {
        for letter in letters.chars() {
            let (text, escaped) = (format!("a{letter}b"), letter.escape_default().to_string());
            let expected = if is_seen {
                text.clone()
            } else {
                // The standard library has a short form for zero, too.
                format!("a{}b", if letter == '\0' { "\\0" } else { &escaped })
            };
            assert_eq!(one_line(&text), expected, "{category} U+{:04X}", u32::from(letter));
            let kept = if letter == '\n' { text } else { expected };
            assert_eq!(lines(&kept), kept, "{category}");
        }
    }
    assert_eq!(one_line(" a b "), " a b ");
    for text in texts() {
        assert!(
            matches!(one_line(&one_line(&text)), std::borrow::Cow::Borrowed(_)),
            "{text:?}: twice as once"
        );
    }
}

/// The fields of one record by RFC 4180.
fn fields(record: &str) -> Vec<String> {
    let (mut fields, mut is_quoted, mut letters) = (vec![String::new()], false, record.chars().peekable());
    while let Some(letter) = letters.next() {
        match letter {
            '"' if is_quoted && letters.next_if_eq(&'"').is_some() => fields.last_mut().unwrap().push('"'),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => fields.push(String::new()),
            letter => fields.last_mut().unwrap().push(letter),
        }
    }
    assert!(!is_quoted);
    fields
}

#[test]
fn a_table_has_one_line_and_the_same_cells() {
    let texts: Vec<String> = texts().collect();
    let cells: Vec<_> = texts.iter().map(|text| csv_cell(text)).collect();
    let record = cells.join(",");
    assert!(!record.contains(['\n', '\r']));
    let expected: Vec<_> = texts.iter().map(|text| one_line(text).into_owned()).collect();
    assert_eq!(fields(&record), expected);
}

#[test]
fn elements_and_attributes_have_the_text() {
    for text in texts() {
        let document = format!("<svg label=\"{0}\" other='{0}'>{0}</svg>", xml(&text));
        let document = robot_dynamics_xml::roxmltree::Document::parse(&document).unwrap();
        let (root, expected) = (document.root_element(), one_line(&text));
        assert_eq!(root.text().unwrap_or_default(), expected);
        assert_eq!((root.attribute("label"), root.attribute("other")), (Some(&*expected), Some(&*expected)));
    }
}

/// This test applies the rules of CommonMark and of GitHub's tables to each letter, instead of a Markdown
/// parser.
#[test]
fn markdown_has_no_markup_of_a_name() {
    for text in texts() {
        let (written, seen) = (markdown(&text), one_line(&text));
        assert!(!written.contains('\n'));
        let mut letters = written.chars();
        let mut read = String::new();
        while let Some(letter) = letters.next() {
            assert!(!"|<>[]*`~&#@!$^{}".contains(letter), "{written:?} has {letter:?} without a backslash");
            // A backslash before punctuation stands for the punctuation.
            read.push(if letter == '\\' { letters.next().unwrap() } else { letter });
        }
        assert_eq!(read, seen);

        let code = markdown_code(&text);
        let fence = code.len() - code.trim_start_matches('`').len();
        let inner = &code[fence..code.len() - fence];
        assert!(code.ends_with(&"`".repeat(fence)) && !code.contains('\n'), "{code:?}");
        assert!(inner.split(|letter| letter != '`').all(|run| run.len() != fence), "{code:?} ends early");
        let is_padded =
            inner.starts_with(' ') && inner.ends_with(' ') && inner.len() > 1 && !inner.trim().is_empty();
        let inner = if is_padded { &inner[1..inner.len() - 1] } else { inner };
        let inner = inner.replace("\\|", "|");
        assert!(inner == seen || seen.trim().is_empty() && inner.trim().is_empty(), "{code:?}");
        assert_eq!(code.replace("\\|", "").matches('|').count(), 0, "a cell of a table ends at {code:?}");
    }
    assert_eq!(markdown("http://a.b www.c.d two_r _two_"), r"http\://a.b www\.c.d two_r \_two\_");
}

#[test]
fn json_has_the_same_values() {
    for text in texts() {
        // A reference that escapes only what JSON requires.
        let plain: String = text
            .chars()
            .map(|letter| match letter {
                '"' | '\\' => format!("\\{letter}"),
                letter if u32::from(letter) < 32 => format!("\\u{:04x}", u32::from(letter)),
                letter => letter.to_string(),
            })
            .collect();
        let line = format!("[\"{plain}\"]\n");
        let written = json(&line);
        assert_eq!(one_line(written.trim_end()), written.trim_end());
        assert_eq!(unescaped(&written[2..written.len() - 3]), text);
    }
}

/// Decodes a JSON string.
fn unescaped(text: &str) -> String {
    let (mut units, mut rest) = (Vec::new(), text);
    while let Some(letter) = rest.chars().next() {
        if let Some(code) = rest.strip_prefix("\\u") {
            units.push(u16::from_str_radix(&code[..4], 16).unwrap());
            rest = &code[4..];
            continue;
        }
        let own = if letter == '\\' { &rest[1..] } else { rest };
        let letter = own.chars().next().unwrap();
        units.extend_from_slice(letter.encode_utf16(&mut [0; 2]));
        rest = &own[letter.len_utf8()..];
    }
    String::from_utf16(&units).unwrap()
}
