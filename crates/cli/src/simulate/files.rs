//! The files of a run: opened before it, in their places after it.

use std::path::{Path, PathBuf};

use multibody::{Model, Moment};

use super::csv::CsvFile;
use super::plot::Plot;
use crate::failure::{Context, Failure};
use crate::whole_file::WholeFile;

/// The files asked for.
pub(crate) struct Files {
    csv: Option<CsvFile>,
    csv_shown: String,
    plot: Option<(WholeFile, PathBuf)>,
}

/// What was written.
pub(crate) struct Written {
    /// Each with what it holds.
    pub files: Vec<(PathBuf, String)>,
}

impl Files {
    /// Opens them all, so that a wrong path costs no run.
    pub(crate) fn open(
        model: &Model,
        csv: Option<&Path>,
        every: u32,
        plot: Option<&Path>,
    ) -> Result<Self, Failure> {
        if let (Some(csv), Some(plot)) = (csv, plot)
            && csv == plot
        {
            return Err(Failure::new(format!("--csv and --plot both name {}", csv.display())));
        }
        let csv_shown = csv.map_or_else(String::new, |path| path.display().to_string());
        let csv = match csv {
            Some(path) => {
                let file = WholeFile::create(path)?;
                let started = CsvFile::start(file, model, every as usize);
                Some(started.context(format!("cannot write {csv_shown}"))?)
            }
            None => None,
        };
        let plot = match plot {
            Some(path) => Some((WholeFile::create(path)?, path.to_owned())),
            None => None,
        };
        Ok(Self { csv, csv_shown, plot })
    }

    pub(crate) fn see(&mut self, moment: &Moment<'_>, is_last: bool) -> Result<(), Failure> {
        match &mut self.csv {
            Some(csv) => csv.see(moment, is_last).context(format!("cannot write {}", self.csv_shown)),
            None => Ok(()),
        }
    }

    /// Draws the plot and moves every file to its place, or to that of a partial one.
    pub(crate) fn finish(self, picture: &Plot<'_>, is_whole: bool) -> Result<Written, Failure> {
        let place = |file: WholeFile| if is_whole { file.finish() } else { file.finish_partial() };
        let mut files = Vec::new();
        if let Some(csv) = self.csv {
            let rows = csv.rows;
            files.push((place(csv.into_file())?, format!("{rows} samples")));
        }
        if let Some((mut file, path)) = self.plot {
            picture.draw(&mut file, &path).context(format!("cannot draw {}", path.display()))?;
            files.push((place(file)?, "plot".into()));
        }
        Ok(Written { files })
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
