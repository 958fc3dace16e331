//! The files of a run: opened before it, in their places after it.

use std::io::{self, ErrorKind};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use multibody::{Model, Moment};

use super::csv::{Beside, CsvFile};
use super::plot::Plot;
use crate::destination::{refuse_clashes, shown};
use crate::failure::{Context, Failure};
use crate::output_file::OutputFile;

/// The files asked for.
pub(crate) struct Files {
    csv: Option<(CsvFile, String)>,
    plot: Option<(OutputFile, PathBuf)>,
    /// Why no more rows can be written, and when that was \[s\].
    trouble: Option<(io::Error, f64)>,
}

/// What was written.
#[derive(Default)]
pub(crate) struct Written {
    /// Each with what it holds.
    pub files: Vec<(PathBuf, String)>,
    /// What could not be written, and why.
    pub troubles: Vec<String>,
    /// Whether a reader of the table had seen enough of it.
    pub reader_left: bool,
}

impl Files {
    /// Opens them all, so that a wrong path costs no run. None may be the file that the robot came from.
    pub(crate) fn open(
        model: &Model,
        robot: &Path,
        (csv, every, beside): (Option<&Path>, u32, Beside<'_>),
        plot: Option<&Path>,
    ) -> Result<Self, Failure> {
        let outputs: Vec<_> = [("--csv", csv), ("--plot", plot)]
            .into_iter()
            .filter_map(|(role, path)| Some((role, path?)))
            .collect();
        refuse_clashes(&[("the robot's file", robot)], &outputs)?;
        let csv = match csv {
            Some(path) => {
                let shown = path.display().to_string();
                let started = CsvFile::start(OutputFile::create(path)?, model, every as usize, beside);
                Some((started.context(format!("cannot write {shown}"))?, shown))
            }
            None => None,
        };
        let plot = match plot {
            Some(path) => Some((OutputFile::create(path)?, path.to_owned())),
            None => None,
        };
        Ok(Self { csv, plot, trouble: None })
    }

    /// Whether the table goes to standard output, where no summary may then stand.
    pub(crate) fn use_standard_output(&mut self) -> bool {
        self.csv.as_mut().is_some_and(|(csv, _)| csv.file().is_standard_output())
    }

    /// Writes the row of this moment; breaks off when it cannot be written.
    pub(crate) fn see(&mut self, moment: &Moment<'_>, is_last: bool) -> ControlFlow<()> {
        let Some((csv, _)) = &mut self.csv else { return ControlFlow::Continue(()) };
        match csv.see(moment, is_last) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.trouble = Some((error, moment.time));
                ControlFlow::Break(())
            }
        }
    }

    /// Draws the plot and moves every file to its place, or to that of a partial one. What cannot be written to its
    /// end is kept as far as it fits.
    pub(crate) fn finish(mut self, picture: &Plot<'_>, is_whole: bool) -> Written {
        let mut written = Written::default();
        if let Some((csv, shown)) = self.csv {
            close_table(csv, &shown, self.trouble.take(), is_whole, &mut written);
        }
        if let Some((mut file, path)) = self.plot {
            let drawn =
                picture.draw(&mut file, &path).and_then(|()| file.finish(is_whole).map_err(Failure::new));
            match drawn {
                Ok(place) => written.files.push((shown(&place), "plot".into())),
                Err(error) => written.troubles.push(format!("cannot draw {}: {error}", path.display())),
            }
        }
        written
    }
}

/// Ends the table; after trouble, or when its last rows do not fit, keeps the rows that do.
fn close_table(
    mut csv: CsvFile,
    name: &str,
    trouble: Option<(io::Error, f64)>,
    is_whole: bool,
    written: &mut Written,
) {
    let rows = csv.rows;
    let (error, time) = match trouble {
        Some((error, time)) => (error, format!(" from t = {time} s on")),
        None => match csv.file().finish(is_whole) {
            Ok(place) => {
                written.files.push((shown(&place), format!("{rows} samples")));
                return;
            }
            Err(error) => (error, " to its end".to_owned()),
        },
    };
    if error.kind() == ErrorKind::BrokenPipe {
        written.reader_left = true;
        return;
    }
    written.troubles.push(format!("cannot write {name}{time}: {error}"));
    if let Ok((place, lines)) = csv.file().keep_lines() {
        // The first line is the head.
        written.files.push((shown(&place), format!("{} samples", lines - 1)));
    }
}

impl Written {
    /// What is left of a run that failed, for its message.
    pub(crate) fn kept(&self) -> String {
        if self.files.is_empty() {
            return String::new();
        }
        let names: Vec<String> = self.files.iter().map(|(path, _)| path.display().to_string()).collect();
        format!("; kept up to there: {}", names.join(", "))
    }
}
