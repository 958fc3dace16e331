//! Outputs of a command: a file or a stream.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use robot_dynamics::output::replace_all;

use crate::destination::Destination;
use crate::failure::{Context, Failure};
use crate::whole_file::WholeFile;

/// An open output.
pub(crate) enum OutputFile {
    /// A file that is replaced as a whole, or stays as it was.
    Whole(WholeFile),
    /// A stream, which cannot be taken back, with its path; `None` for standard output.
    Stream(BufWriter<Box<dyn Write>>, Option<PathBuf>),
}

impl OutputFile {
    /// Opens the output, so that a path that cannot be written fails before the work is done.
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

    /// Whether it is standard output, where no other text may then be printed.
    pub(crate) fn is_standard_output(&self) -> bool {
        matches!(self, Self::Stream(_, None))
    }

    /// Closes an unfinished file as a partial one. Returns its path.
    pub(crate) fn finish_partial(&mut self) -> io::Result<PathBuf> {
        match self {
            Self::Whole(file) => file.finish_partial(),
            Self::Stream(..) => self.flush().map(|()| self.place()),
        }
    }

    /// The path of the finished output.
    fn place(&self) -> PathBuf {
        match self {
            Self::Whole(file) => file.target().to_owned(),
            Self::Stream(_, place) => place.clone().unwrap_or_else(|| "standard output".into()),
        }
    }

    /// See [`WholeFile::keep_lines`]; a stream cannot keep anything.
    pub(crate) fn keep_lines(&mut self) -> io::Result<(PathBuf, usize)> {
        match self {
            Self::Whole(file) => file.keep_lines(),
            Self::Stream(..) => Err(io::Error::other("a stream cannot be cut")),
        }
    }
}

/// Completes all outputs: all files are replaced, or none. Returns their paths.
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
