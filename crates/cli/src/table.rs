//! Plain-text tables: columns padded to their widest cell.

use multibody::text::one_line;

/// A table being filled; the first row is the head.
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
    /// Whether a column is flush right, as numbers are.
    right: Vec<bool>,
}

impl Table {
    /// A table with this head; a column whose head starts with `>` is flush right.
    pub(crate) fn new(head: &[&str]) -> Self {
        let right = head.iter().map(|cell| cell.starts_with('>')).collect();
        let head = head.iter().map(|cell| cell.trim_start_matches('>').to_string()).collect();
        Self { rows: vec![head], right }
    }

    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let row: Vec<String> = cells.into_iter().map(|cell| one_line(&cell).into_owned()).collect();
        assert_eq!(row.len(), self.right.len(), "a table row has as many cells as the head");
        self.rows.push(row);
    }

    /// The table's lines, each indented by two spaces.
    fn lines(&self) -> Vec<String> {
        let width =
            |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.right.len()).map(width).collect();
        let cell = |column: usize, text: &str| {
            let padding = " ".repeat(widths[column] - text.chars().count());
            if self.right[column] { padding + text } else { text.to_string() + &padding }
        };
        let line = |row: &Vec<String>| {
            let cells: Vec<String> =
                row.iter().enumerate().map(|(column, text)| cell(column, text)).collect();
            format!("  {}", cells.join("  ")).trim_end().to_string()
        };
        self.rows.iter().map(line).collect()
    }

    /// The lines, each ended.
    pub(crate) fn text(&self) -> String {
        self.lines().join("\n") + "\n"
    }
}

/// A number with four significant digits, or `-` where there is none.
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
    // The exponent is taken after rounding, so that 9.99996 becomes 10 and not 10.000.
    let rounded = format!("{x:.3e}");
    let exponent: i32 = rounded.rsplit_once('e').and_then(|(_, digits)| digits.parse().ok()).unwrap_or(0);
    let text = format!("{x:.*}", usize::try_from(3 - exponent).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
