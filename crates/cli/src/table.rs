//! Plain-text tables with columns padded to their widest cell, and numbers as text.

use robot_dynamics::text::one_line;

/// A table under construction; the first row is the head. All cells share one string, as a robot may have a
/// million joints.
pub(crate) struct Table {
    /// All cells, row by row.
    text: String,
    /// The end of each cell in the text.
    ends: Vec<usize>,
    /// The width of each column in characters.
    widths: Vec<usize>,
    /// Whether a column is right-aligned.
    right: Vec<bool>,
}

impl Table {
    /// A table with this head. A column whose head starts with `>` is right-aligned.
    pub(crate) fn new(head: &[&str]) -> Self {
        let right: Vec<bool> = head.iter().map(|cell| cell.starts_with('>')).collect();
        let mut table = Self { text: String::new(), ends: Vec::new(), widths: vec![0; right.len()], right };
        table.row(head.iter().map(|cell| cell.trim_start_matches('>').to_owned()));
        table
    }

    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let first = self.ends.len();
        for cell in cells {
            let cell = one_line(&cell);
            if let Some(width) = self.widths.get_mut(self.ends.len() - first) {
                *width = cell.chars().count().max(*width);
            }
            self.text.push_str(&cell);
            self.ends.push(self.text.len());
        }
        assert_eq!(self.ends.len() - first, self.right.len(), "a row must have as many cells as the head");
    }

    /// The lines, each indented by two spaces.
    pub(crate) fn text(&self) -> String {
        let (mut text, mut start) = (String::new(), 0);
        for row in self.ends.chunks(self.right.len()) {
            let line = text.len();
            for ((&end, &width), &right) in row.iter().zip(&self.widths).zip(&self.right) {
                let cell = &self.text[start..end];
                let padding = width - cell.chars().count();
                let (before, after) = if right { (padding, 0) } else { (0, padding) };
                text.push_str("  ");
                text.extend(core::iter::repeat_n(' ', before));
                text.push_str(cell);
                text.extend(core::iter::repeat_n(' ', after));
                start = end;
            }
            text.truncate(line + text[line..].trim_end().len());
            text.push('\n');
        }
        text
    }
}

/// A number with four significant digits, or `-` if it is infinite.
pub(crate) fn short(x: f64) -> String {
    if x.is_infinite() {
        return "-".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&x.abs()) {
        return format!("{x:.2e}");
    }
    // The exponent is that after rounding, so that 9.99996 becomes 10 and not 10.000.
    let rounded = format!("{x:.3e}");
    let exponent: i32 = rounded.rsplit_once('e').and_then(|(_, digits)| digits.parse().ok()).unwrap_or(0);
    let text = format!("{x:.*}", usize::try_from(3 - exponent).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Formats a number for the table: fixed point between 0.01 and 10 000, an exponent otherwise.
pub(crate) fn short_or_exponent(x: f64) -> String {
    match x {
        x if x.is_nan() => "NaN".into(),
        x if x.is_infinite() => "∞".into(),
        x if x == 0.0 || (0.01..10_000.0).contains(&x.abs()) => short(x),
        x => format!("{x:.1e}"),
    }
}

/// `1 link`, `2 links`.
pub(crate) fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}
