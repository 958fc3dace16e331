//! What a command writes to: a file of its own, or a stream.

use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

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

    /// Ends it: in its place if it is whole, else beside it as a partial one. Says where.
    pub(crate) fn finish(&mut self, is_whole: bool) -> io::Result<PathBuf> {
        match self {
            Self::Whole(file) if is_whole => file.finish(),
            Self::Whole(file) => file.finish_partial(),
            Self::Stream(stream, place) => {
                stream.flush()?;
                Ok(place.clone().unwrap_or_else(|| "standard output".into()))
            }
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
