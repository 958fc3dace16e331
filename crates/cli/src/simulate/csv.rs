//! The samples of a run as comma-separated values.

use std::io::Write;

use multibody::text::csv_cell;
use multibody::{Losses, Model, StepInfo};

use crate::columns::{self, Column};
use crate::output_file::OutputFile;

/// What a run has beside its states: links that can touch the ground, and losses told apart.
#[derive(Clone, Copy)]
pub(crate) struct Beside<'a> {
    pub touching: &'a [String],
    pub has_losses: bool,
}

/// What took energy out, in words; the last two are the ground's.
pub(crate) const LOSSES: [&str; 6] = ["damping", "friction", "stops", "corrections", "sliding", "impacts"];

/// The losses in that order \[J\].
pub(crate) fn numbers(losses: &Losses) -> [f64; 6] {
    let Losses { damping, friction, stops, corrections, sliding, impacts, .. } = *losses;
    [damping, friction, stops, corrections, sliding, impacts]
}

impl Beside<'_> {
    /// Those of the losses that can be.
    pub(crate) fn losses(&self) -> &'static [&'static str] {
        match (self.has_losses, self.touching.is_empty()) {
            (false, _) => &[],
            (true, true) => &LOSSES[..4],
            (true, false) => &LOSSES,
        }
    }
}

/// A table being written: time, q, v, τ, energies, losses, forces of contact.
pub(crate) struct CsvFile {
    file: OutputFile,
    every: usize,
    /// How many of them have a column.
    losses: usize,
    last: usize,
    pub rows: usize,
    line: String,
}

impl CsvFile {
    /// Starts the table with its head; a row follows every so many steps, and one at the end.
    pub(crate) fn start(
        mut file: OutputFile,
        model: &Model,
        every: usize,
        beside: Beside<'_>,
    ) -> std::io::Result<Self> {
        let named = |letter: &'static str, columns: Vec<Column>| {
            columns.into_iter().map(move |column| format!("{letter} {} [{}]", column.name, column.unit))
        };
        let mut head = vec!["t [s]".to_owned()];
        head.extend(named("q", columns::configuration(model)));
        head.extend(named("v", columns::velocity(model)));
        head.extend(named("tau", columns::effort(model)));
        head.extend(["K [J]", "V [J]", "E [J]", "energy error [J]"].map(str::to_owned));
        let losses = beside.losses();
        head.extend(losses.iter().map(|cause| format!("{cause} took out [J]")));
        for link in beside.touching {
            head.extend(["x", "y", "z"].map(|axis| format!("contact {link}.{axis} [N]")));
        }
        let head: Vec<String> = head.iter().map(|cell| csv_cell(cell).into_owned()).collect();
        writeln!(file, "{}", head.join(","))?;
        Ok(Self { file, every, losses: losses.len(), last: 0, rows: 0, line: String::new() })
    }

    /// The row of this moment, if it is its turn or the last.
    pub(crate) fn see(&mut self, info: &StepInfo<'_>, is_last: bool) -> std::io::Result<()> {
        use std::fmt::Write as _;
        if !info.step.is_multiple_of(self.every) && !is_last || self.rows > 0 && info.step == self.last {
            return Ok(());
        }
        let ledger = info.ledger;
        let energies =
            [ledger.kinetic(), ledger.potential(), ledger.kinetic() + ledger.potential(), ledger.imbalance()];
        self.line.clear();
        let _ = write!(self.line, "{:?}", info.time);
        let losses = numbers(&info.losses.unwrap_or_default());
        let (losses, contact) = (&losses[..self.losses], info.contact_forces.as_flattened());
        for x in [info.q, info.v, info.tau, &energies, losses, contact].into_iter().flatten() {
            // The shortest digits that read back as the same number.
            let _ = write!(self.line, ",{x:?}");
        }
        self.line.push('\n');
        self.file.write_all(self.line.as_bytes())?;
        (self.last, self.rows) = (info.step, self.rows + 1);
        Ok(())
    }

    pub(crate) fn file(&mut self) -> &mut OutputFile {
        &mut self.file
    }
}
