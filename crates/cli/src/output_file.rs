//! What a command writes to: a file of its own, or a stream.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use robot_dynamics::output::replace_all;

use crate::destination::Destination;
use crate::failure::{Context, Failure};
use crate::whole_file::WholeFile;

/// An output under way.
pub(crate) enum OutputFile {
    /// A file, there as a whole or not at all.
    Whole(WholeFile),
    /// A stream: what is written is gone. Its path, or none of standard output.
    Stream(BufWriter<Box<dyn Write>>, Option<PathBuf>),
}

impl OutputFile {
    /// Opens it, so that a place that cannot be written is known before the work is done.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        Ok(match Destination::of(path)? {
            Destination::StandardOutput => Self::Stream(BufWriter::new(Box::new(io::stdout())), None),
            Destination::Stream(place) => {
                let opened = OpenOptions::new().write(true).open(&place);
                let stream = opened.context(format!("cannot write {}", path.display()))?;
                Self::Stream(BufWriter::new(Box::new(stream)), Some(place))
            }
            Destination::File(target) => Self::Whole(WholeFile::create(target, &path.display().to_string())?),
        })
    }

    /// Whether it goes to standard output, where nothing else may then be printed.
    pub(crate) fn is_standard_output(&self) -> bool {
        matches!(self, Self::Stream(_, None))
    }

    /// Ends an unfinished one: beside its place, as a partial one. Says where.
    pub(crate) fn finish_partial(&mut self) -> io::Result<PathBuf> {
        match self {
            Self::Whole(file) => file.finish_partial(),
            Self::Stream(..) => self.flush().map(|()| self.place()),
        }
    }

    /// Where it is when it is finished.
    fn place(&self) -> PathBuf {
        match self {
            Self::Whole(file) => file.target().to_owned(),
            Self::Stream(_, place) => place.clone().unwrap_or_else(|| "standard output".into()),
        }
    }

    /// See [`WholeFile::keep_lines`]; of a stream nothing can be kept.
    pub(crate) fn keep_lines(&mut self) -> io::Result<(PathBuf, usize)> {
        match self {
            Self::Whole(file) => file.keep_lines(),
            Self::Stream(..) => Err(io::Error::other("nothing is kept of a stream")),
        }
    }
}

/// Ends finished outputs: all files are in their places, or none. Says where.
pub(crate) fn finish_all(outputs: &mut [&mut OutputFile]) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for output in outputs.iter_mut() {
        match output {
            OutputFile::Whole(file) => files.push(file.complete()?),
            OutputFile::Stream(stream, _) => stream.flush()?,
        }
    }
    replace_all(&files)?;
    Ok(outputs.iter().map(|output| output.place()).collect())
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Whole(file) => file.write(bytes),
            Self::Stream(stream, _) => stream.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Whole(file) => file.flush(),
            Self::Stream(stream, _) => stream.flush(),
        }
    }
}
