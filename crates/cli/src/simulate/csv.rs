//! The samples of a run as comma-separated values.

use std::io::Write;

use multibody::{Model, Moment};

use crate::columns::{self, Column};
use crate::output_file::OutputFile;

/// A table being written: time, q, v, τ, energies.
pub(crate) struct CsvFile {
    file: OutputFile,
    every: usize,
    last: usize,
    pub rows: usize,
    line: String,
}

impl CsvFile {
    /// Starts the table with its head; a row follows every so many steps, and one at the end.
    pub(crate) fn start(mut file: OutputFile, model: &Model, every: usize) -> std::io::Result<Self> {
        let named = |letter: &'static str, columns: Vec<Column>| {
            columns.into_iter().map(move |column| format!("{letter} {} [{}]", column.name, column.unit))
        };
        let mut head = vec!["t [s]".to_owned()];
        head.extend(named("q", columns::configuration(model)));
        head.extend(named("v", columns::velocity(model)));
        head.extend(named("tau", columns::effort(model)));
        head.extend(["K [J]", "V [J]", "E [J]", "energy error [J]"].map(str::to_owned));
        let head: Vec<String> = head.iter().map(|cell| quoted(cell)).collect();
        writeln!(file, "{}", head.join(","))?;
        Ok(Self { file, every, last: 0, rows: 0, line: String::new() })
    }

    /// The row of this moment, if it is its turn or the last.
    pub(crate) fn see(&mut self, moment: &Moment<'_>, is_last: bool) -> std::io::Result<()> {
        use std::fmt::Write as _;
        if !moment.step.is_multiple_of(self.every) && !is_last || self.rows > 0 && moment.step == self.last {
            return Ok(());
        }
        let ledger = moment.ledger;
        let energies =
            [ledger.kinetic(), ledger.potential(), ledger.kinetic() + ledger.potential(), ledger.imbalance()];
        self.line.clear();
        let _ = write!(self.line, "{:?}", moment.time);
        for x in [moment.q, moment.v, moment.tau, &energies].into_iter().flatten() {
            // The shortest digits that read back as the same number.
            let _ = write!(self.line, ",{x:?}");
        }
        self.line.push('\n');
        self.file.write_all(self.line.as_bytes())?;
        (self.last, self.rows) = (moment.step, self.rows + 1);
        Ok(())
    }

    pub(crate) fn file(&mut self) -> &mut OutputFile {
        &mut self.file
    }
}

/// A cell as RFC 4180 wants it.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.into()
    }
}
