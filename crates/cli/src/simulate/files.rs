//! The files of a run: opened before it, in their places after it.

use std::io::{self, ErrorKind, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use multibody::{Model, StepInfo};

use super::csv::{Beside, CsvFile};
use super::plot::Plot;
use crate::destination::{refuse_clashes, shown};
use crate::failure::{Context, Failure};
use crate::output_file::{OutputFile, finish_all};

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
    /// Opens them all, so that a wrong path costs no run. None may be a file that the robot was read from:
    /// its own, or one of `read`.
    pub(crate) fn open(
        model: &Model,
        (robot, read): (&Path, &[PathBuf]),
        (csv, every, beside): (Option<&Path>, u32, Beside<'_>),
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
    pub(crate) fn see(&mut self, info: &StepInfo<'_>, is_last: bool) -> ControlFlow<()> {
        let Some((csv, _)) = &mut self.csv else { return ControlFlow::Continue(()) };
        match csv.see(info, is_last) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.trouble = Some((error, info.time));
                ControlFlow::Break(())
            }
        }
    }

    /// Draws the plot and moves every file to its place. If the run ended early, or one of them cannot be written to its
    /// end, none is moved there: each is kept beside its place, as far as it fits.
    pub(crate) fn finish(mut self, picture: &Plot<'_>, is_whole: bool) -> Written {
        let mut written = Written::default();
        // Every file is complete before the first is moved.
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
                Err(error) => written.troubles.push(format!("cannot put the files in their places: {error}")),
            }
        }
        let is_cut = tabled.is_err();
        for (output, holds) in self.outputs().into_iter().zip(holds) {
            if is_cut && holds != "plot" {
                // The first line is the head.
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

    /// Writes the table's last rows; what went wrong with it by then, and when.
    fn close_table(&mut self) -> Result<(), (io::Error, String)> {
        if let Some((error, time)) = self.trouble.take() {
            return Err((error, format!(" from t = {time} s on")));
        }
        let flushed = self.csv.as_mut().map_or(Ok(()), |(csv, _)| csv.file().flush());
        flushed.map_err(|error| (error, " to its end".to_owned()))
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
