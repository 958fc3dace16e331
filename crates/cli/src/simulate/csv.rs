//! The samples of a run as comma-separated values.

use std::io::Write;

use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Losses, StepInfo};
use robot_dynamics::text::csv_cell;

use crate::columns::{self, Column};
use crate::output_file::OutputFile;

/// The optional columns: forces on links that can touch the ground, and separate losses.
#[derive(Clone, Copy)]
pub(crate) struct OptionalColumns<'a> {
    pub touching: &'a [String],
    pub has_losses: bool,
}

/// Names of the losses; the last two are those of the ground.
pub(crate) const LOSSES: [&str; 6] = ["damping", "friction", "stops", "corrections", "sliding", "impacts"];

/// The losses in that order \[J\].
pub(crate) fn numbers(losses: &Losses) -> [f64; 6] {
    let Losses { damping, friction, stops, corrections, sliding, impacts, .. } = *losses;
    [damping, friction, stops, corrections, sliding, impacts]
}

impl OptionalColumns<'_> {
    /// The names of the losses that can occur.
    pub(crate) fn losses(&self) -> &'static [&'static str] {
        match (self.has_losses, self.touching.is_empty()) {
            (false, _) => &[],
            (true, true) => &LOSSES[..4],
            (true, false) => &LOSSES,
        }
    }
}

/// A table with time, q, v, τ, energies, losses and contact forces.
pub(crate) struct CsvFile {
    file: OutputFile,
    /// Number of steps between rows.
    stride: usize,
    /// Number of losses with a column.
    losses: usize,
    last: usize,
    pub rows: usize,
    line: String,
}

impl CsvFile {
    /// Writes the header. Then every `stride`-th step and the last step get a row.
    pub(crate) fn start(
        mut file: OutputFile,
        model: &Model,
        stride: usize,
        columns: OptionalColumns<'_>,
    ) -> std::io::Result<Self> {
        let named = |letter: &'static str, columns: Vec<Column>| {
            columns.into_iter().map(move |column| format!("{letter} {} [{}]", column.name, column.unit))
        };
        let mut head = vec!["t [s]".to_owned()];
        head.extend(named("q", columns::configuration(model)));
        head.extend(named("v", columns::velocity(model)));
        head.extend(named("tau", columns::effort(model)));
        head.extend(["K [J]", "V [J]", "E [J]", "energy error [J]"].map(str::to_owned));
        let losses = columns.losses();
        head.extend(losses.iter().map(|cause| format!("{cause} took out [J]")));
        for link in columns.touching {
            head.extend(["x", "y", "z"].map(|axis| format!("contact {link}.{axis} [N]")));
        }
        let head: Vec<String> = head.iter().map(|cell| csv_cell(cell).into_owned()).collect();
        writeln!(file, "{}", head.join(","))?;
        Ok(Self { file, stride, losses: losses.len(), last: 0, rows: 0, line: String::new() })
    }

    /// Writes the row of this step if it is due or the last.
    pub(crate) fn record(&mut self, info: &StepInfo<'_>, is_last: bool) -> std::io::Result<()> {
        use std::fmt::Write as _;
        if !info.step.is_multiple_of(self.stride) && !is_last || self.rows > 0 && info.step == self.last {
            return Ok(());
        }
        let energy_account = info.energy_account;
        let energies = [
            energy_account.kinetic(),
            energy_account.potential(),
            energy_account.kinetic() + energy_account.potential(),
            energy_account.imbalance(),
        ];
        self.line.clear();
        let _ = write!(self.line, "{:?}", info.time);
        let losses = numbers(&info.losses.unwrap_or_default());
        let (losses, contact) = (&losses[..self.losses], info.contact_forces.as_flattened());
        for x in [info.q, info.v, info.tau, &energies, losses, contact].into_iter().flatten() {
            // The shortest digits that parse to the same number.
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
