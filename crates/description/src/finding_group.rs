//! Groups of similar findings, each reported in one line with a count.

use core::fmt;
use core::mem::discriminant;
use std::collections::HashMap;

use super::report::{Finding, LoadReport};
use crate::text::one_line;

/// Findings of one kind: the same disposition, elements of the same types, and messages that differ only in
/// numbers and in quoted values. Its text is that of the first finding, followed by the number of the others
/// and their first places.
///
/// ```
/// use robot_dynamics::description::{Finding, LoadReport, Disposition};
/// let mut report = LoadReport::default();
/// for (line, joint) in [(4, "hip"), (9, "knee")] {
///     let place = format!("joint {joint:?}/dynamics");
///     report.add(Finding::new(line, place, Disposition::Ignored { physics: true }, "unknown attribute D=\"1\""));
/// }
/// let groups = report.grouped_warnings();
/// assert_eq!(groups.len(), 1);
/// assert_eq!(
///     groups[0].to_string(),
///     "line 4: joint \"hip\"/dynamics: unknown attribute D=\"1\" (2 of this kind; also at line 9: joint \"knee\"/dynamics)"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FindingGroup<'a> {
    findings: Vec<&'a Finding>,
}

/// The number of places that a group's text names after the first.
const PLACES_SHOWN: usize = 3;

/// The line of a finding with its colon; empty for formats without lines.
fn line_text(finding: &Finding) -> String {
    if finding.line() == 0 { String::new() } else { format!("line {}: ", finding.line()) }
}

impl<'a> FindingGroup<'a> {
    /// The findings, at least one, in the order of the report.
    pub fn findings(&self) -> &[&'a Finding] {
        &self.findings
    }
}

impl fmt::Display for FindingGroup<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, others @ ..] = &self.findings[..] else { return Ok(()) };
        let (place, message) = (one_line(first.place()), one_line(first.message()));
        write!(f, "{}{place}: {message}", line_text(first))?;
        if others.is_empty() {
            return Ok(());
        }
        write!(f, " ({} of this kind; also at ", self.findings.len())?;
        for (at, other) in others.iter().take(PLACES_SHOWN).enumerate() {
            let separator = if at == 0 { "" } else { "; " };
            write!(f, "{separator}{}{}", line_text(other), one_line(other.place()))?;
        }
        match others.len().saturating_sub(PLACES_SHOWN) {
            0 => write!(f, ")"),
            more => write!(f, "; and {more} more)"),
        }
    }
}

impl LoadReport {
    /// The [`warnings`](Self::warnings), grouped by kind, in the order of the first of each kind; see
    /// [`FindingGroup`].
    ///
    /// ```
    /// assert!(robot_dynamics::description::LoadReport::default().grouped_warnings().is_empty());
    /// ```
    pub fn grouped_warnings(&self) -> Vec<FindingGroup<'_>> {
        let mut groups: Vec<FindingGroup<'_>> = Vec::new();
        let mut known = HashMap::new();
        for finding in self.warnings() {
            let (place, message) = (without_values(finding.place()), without_values(finding.message()));
            let at =
                *known.entry((discriminant(&finding.disposition()), place, message)).or_insert(groups.len());
            match groups.get_mut(at) {
                Some(group) => group.findings.push(finding),
                None => groups.push(FindingGroup { findings: vec![finding] }),
            }
        }
        groups
    }
}

/// A text with empty quotes and with `#` for each number. A digit within a name, as in `mu2`, is part of the
/// name.
fn without_values(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let is_in_name = kept.ends_with(|last: char| last.is_alphanumeric() || last == '_');
        let value = if letter == '"' {
            kept.push_str("\"\"");
            quoted_length(rest)
        } else {
            match number_length(rest) {
                length if length > 0 && !is_in_name => {
                    kept.push('#');
                    length
                }
                _ => {
                    kept.push(letter);
                    letter.len_utf8()
                }
            }
        };
        rest = &rest[value..];
    }
    kept
}

/// The length in bytes of the quoted text at the beginning. A backslash escapes quotes inside it.
fn quoted_length(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, letter) in text.char_indices().skip(1) {
        match letter {
            '"' if !is_escaped => return at + 1,
            letter => is_escaped = letter == '\\' && !is_escaped,
        }
    }
    text.len()
}

/// The length in bytes of the number at the beginning, or 0.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with(['-', '+']));
    let mut end = sign + digits(&text[sign..]);
    if end == sign {
        return 0;
    }
    if text[end..].starts_with('.') {
        end += 1 + digits(&text[end + 1..]);
    }
    if let Some(power) = text[end..].strip_prefix(['e', 'E']) {
        let sign = usize::from(power.starts_with(['-', '+']));
        let count = digits(&power[sign..]);
        end += if count > 0 { 1 + sign + count } else { 0 };
    }
    end
}

#[cfg(test)]
mod tests {
    use super::without_values;

    #[test]
    fn values_are_left_out_and_names_are_not() {
        for (text, kept) in [
            ("unknown attribute mu2=\"-3.5e2\"", "unknown attribute mu2=\"\""),
            ("moments 0.01, 1e-3, -2.5 kg·m²", "moments #, #, # kg·m²"),
            ("joint \"a\\\"b\\\\\"/limit", "joint \"\"/limit"),
            ("10 of é3 and \"never closed", "# of é3 and \"\""),
            ("1.e, 2-3, -", "#e, ##, -"),
        ] {
            assert_eq!(without_values(text), kept);
        }
    }
}
