//! The files of a run: opened before it, completed after it.

use std::io::{self, ErrorKind, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use robot_dynamics::model::Model;
use robot_dynamics::simulation::StepInfo;

use super::csv::{CsvFile, OptionalColumns};
use super::plot::Plot;
use crate::destination::{refuse_clashes, shown};
use crate::failure::{Context, Failure};
use crate::output_file::{OutputFile, finish_all};

/// The requested files.
pub(crate) struct Files {
    csv: Option<(CsvFile, String)>,
    plot: Option<(OutputFile, PathBuf)>,
    /// The error that ended writing, and its time \[s\].
    trouble: Option<(io::Error, f64)>,
}

/// The written files.
#[derive(Default)]
pub(crate) struct WrittenFiles {
    /// Each file with a word on its contents.
    pub files: Vec<(PathBuf, String)>,
    /// The files that could not be written, and the errors.
    pub troubles: Vec<String>,
    /// Whether the reader of the table closed its pipe.
    pub reader_left: bool,
}

impl Files {
    /// Opens all files, so that a wrong path fails before the run. None may be a file that the robot was read
    /// from: `robot`, or one of `read`.
    pub(crate) fn open(
        model: &Model,
        (robot, read): (&Path, &[PathBuf]),
        (csv, stride, columns): (Option<&Path>, usize, OptionalColumns<'_>),
        plot: Option<&Path>,
    ) -> Result<Self, Failure> {
        let outputs: Vec<_> = [("--csv", csv), ("--plot", plot)]
            .into_iter()
            .filter_map(|(role, path)| Some((role, path?)))
            .collect();
        refuse_clashes(robot, read, &outputs)?;
        let csv = match csv {
            Some(path) => {
                let shown = path.display().to_string();
                let started = CsvFile::start(OutputFile::create(path)?, model, stride, columns);
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

    /// Whether the table goes to standard output, so that the summary cannot.
    pub(crate) fn use_standard_output(&mut self) -> bool {
        self.csv.as_mut().is_some_and(|(csv, _)| csv.file().is_standard_output())
    }

    /// Writes the row of this step. Breaks if it cannot be written.
    pub(crate) fn record(&mut self, info: &StepInfo<'_>, is_last: bool) -> ControlFlow<()> {
        let Some((csv, _)) = &mut self.csv else { return ControlFlow::Continue(()) };
        match csv.record(info, is_last) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.trouble = Some((error, info.time));
                ControlFlow::Break(())
            }
        }
    }

    /// Draws the plot and completes all files. If the run ended early or a file cannot be completed, all
    /// files become partial files, and the table keeps the rows that fit.
    pub(crate) fn finish(mut self, picture: &Plot<'_>, is_whole: bool) -> WrittenFiles {
        let mut written = WrittenFiles::default();
        // All files are written before the first is renamed.
        let drawn = self.plot.as_mut().map_or(Ok(()), |(file, path)| {
            let drawn = picture.draw(file, path).and_then(|()| file.flush().map_err(Failure::new));
            drawn.map_err(|error| format!("cannot draw {}: {error}", path.display()))
        });
        let tabled = self.close_table();
        written.reader_left = tabled.as_ref().is_err_and(|(error, _)| error.kind() == ErrorKind::BrokenPipe);
        if written.reader_left {
            self.csv = None;
        } else if let (Err((error, time)), Some((_, name))) = (&tabled, &self.csv) {
            written.troubles.push(format!("cannot write {name}{time}: {error}"));
        }
        if let Err(trouble) = drawn {
            written.troubles.push(trouble);
            self.plot = None;
        }
        let holds = self.csv.as_ref().map(|(csv, _)| format!("{} samples", csv.rows));
        let holds: Vec<String> = holds.into_iter().chain(self.plot.as_ref().map(|_| "plot".into())).collect();
        if is_whole && written.troubles.is_empty() {
            match finish_all(&mut self.outputs()) {
                Ok(places) => {
                    written.files = places.iter().map(|place| shown(place)).zip(holds).collect();
                    return written;
                }
                Err(error) => written.troubles.push(format!("cannot rename the files: {error}")),
            }
        }
        let is_cut = tabled.is_err();
        for (output, holds) in self.outputs().into_iter().zip(holds) {
            if is_cut && holds != "plot" {
                // The first line is the header.
                let kept = output.keep_lines();
                written
                    .files
                    .extend(kept.map(|(place, lines)| (shown(&place), format!("{} samples", lines - 1))));
                continue;
            }
            match output.finish_partial() {
                Ok(place) => written.files.push((shown(&place), holds)),
                Err(error) => written.troubles.push(format!("cannot keep the {holds}: {error}")),
            }
        }
        written
    }

    /// The table and the plot.
    fn outputs(&mut self) -> Vec<&mut OutputFile> {
        let csv = self.csv.as_mut().map(|(csv, _)| csv.file());
        csv.into_iter().chain(self.plot.as_mut().map(|(file, _)| file)).collect()
    }

    /// Writes the last rows of the table. The error is that of any earlier row, with its time as text.
    fn close_table(&mut self) -> Result<(), (io::Error, String)> {
        if let Some((error, time)) = self.trouble.take() {
            return Err((error, format!(" from t = {time} s")));
        }
        let flushed = self.csv.as_mut().map_or(Ok(()), |(csv, _)| csv.file().flush());
        flushed.map_err(|error| (error, " to its end".to_owned()))
    }
}

impl WrittenFiles {
    /// The partial files of a failed run, for its message.
    pub(crate) fn kept(&self) -> String {
        if self.files.is_empty() {
            return String::new();
        }
        let names: Vec<String> = self.files.iter().map(|(path, _)| path.display().to_string()).collect();
        format!("; partial results in {}", names.join(", "))
    }
}
