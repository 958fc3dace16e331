//! Files that are written as a whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use robot_dynamics::output::create_beside;

use crate::destination::partial;
use crate::failure::{Context, Failure};

/// A file that is written under a temporary name in the same folder and renamed when it is complete. An older
/// file is replaced by a complete one, or stays.
#[derive(Debug)]
pub(crate) struct WholeFile {
    target: PathBuf,
    temporary: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl WholeFile {
    /// Opens the temporary file, so that a path that cannot be written fails before the work is done. The
    /// links of `target` are already followed. An existing file must be writable and keeps its permissions.
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

    /// Closes the finished file. Returns its temporary path and its target.
    pub(crate) fn complete(&mut self) -> io::Result<(PathBuf, PathBuf)> {
        self.flush()?;
        self.writer = None;
        Ok((self.temporary.clone(), self.target.clone()))
    }

    /// The final path.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Renames an unfinished file to its partial name; a file at the final path stays.
    pub(crate) fn finish_partial(&mut self) -> io::Result<PathBuf> {
        self.flush()?;
        self.rename_to(partial(&self.target))
    }

    /// Cuts a file that could not be written to its end after the last complete line, and renames it to its
    /// partial name. Returns the number of lines. Without a complete line nothing is kept.
    pub(crate) fn keep_lines(&mut self) -> io::Result<(PathBuf, usize)> {
        // Buffered bytes are dropped, as they did not fit.
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
            return Err(io::Error::other("no complete line fits"));
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
    /// Removes the temporary file of an abandoned output. After a rename no file has that name.
    fn drop(&mut self) {
        // The buffered bytes are not written.
        drop(self.writer.take().map(BufWriter::into_parts));
        let _ = fs::remove_file(&self.temporary);
    }
}
