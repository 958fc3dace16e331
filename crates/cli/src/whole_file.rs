//! Files that are there as a whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use robot_dynamics::output::create_beside;

use crate::destination::partial;
use crate::failure::{Context, Failure};

/// A file that is written beside its place under a temporary name and renamed when it is complete, so that
/// an older file there is replaced by a finished one or stays.
#[derive(Debug)]
pub(crate) struct WholeFile {
    target: PathBuf,
    temporary: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl WholeFile {
    /// Opens the temporary file, so that a place that cannot be written is known before the work is done. `target`
    /// has its links followed; the permissions of a file that is there are kept, and must allow writing.
    pub(crate) fn create(target: PathBuf, shown: &str) -> Result<Self, Failure> {
        let doing = || format!("cannot write {shown}");
        let older = fs::metadata(&target).ok();
        if older.is_some() {
            OpenOptions::new().write(true).open(&target).context(doing())?;
        }
        let (temporary, file) = create_beside(&target).context(doing())?;
        let whole = Self { target, temporary, writer: Some(BufWriter::new(file)) };
        if let Some(older) = older {
            fs::set_permissions(&whole.temporary, older.permissions()).context(doing())?;
        }
        Ok(whole)
    }

    /// Closes the finished file: how it is named now, and its place.
    pub(crate) fn complete(&mut self) -> io::Result<(PathBuf, PathBuf)> {
        self.flush()?;
        self.writer = None;
        Ok((self.temporary.clone(), self.target.clone()))
    }

    /// The place where it will be.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Puts an unfinished file beside its place; a file at its place stays.
    pub(crate) fn finish_partial(&mut self) -> io::Result<PathBuf> {
        self.flush()?;
        self.rename_to(partial(&self.target))
    }

    /// Of a file that could not be written to its end: keeps the whole lines that fit beside its place, and says how
    /// many. Nothing is kept of a file without any.
    pub(crate) fn keep_lines(&mut self) -> io::Result<(PathBuf, usize)> {
        // What is still in memory is given up: it did not fit.
        let file = self.writer.take().map(|writer| writer.into_parts().0);
        let mut file = file.ok_or_else(|| io::Error::other("the file is closed"))?;
        file.seek(SeekFrom::Start(0))?;
        let (mut lines, mut end, mut length) = (0, 0, 0);
        let mut reader = BufReader::new(&file);
        loop {
            let bytes = reader.fill_buf()?;
            if bytes.is_empty() {
                break;
            }
            for (at, _) in bytes.iter().enumerate().filter(|&(_, &byte)| byte == b'\n') {
                end = length + at as u64 + 1;
                lines += 1;
            }
            let seen = bytes.len();
            length += seen as u64;
            reader.consume(seen);
        }
        if lines == 0 {
            return Err(io::Error::other("nothing of it fits"));
        }
        file.set_len(end)?;
        drop(file);
        Ok((self.rename_to(partial(&self.target))?, lines))
    }

    fn rename_to(&mut self, target: PathBuf) -> io::Result<PathBuf> {
        self.writer = None;
        fs::rename(&self.temporary, &target)?;
        Ok(target)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for WholeFile {
    /// Given up: nothing is left. After a rename there is nothing of that name.
    fn drop(&mut self) {
        // Without its last bytes, which nobody will see.
        drop(self.writer.take().map(BufWriter::into_parts));
        let _ = fs::remove_file(&self.temporary);
    }
}
