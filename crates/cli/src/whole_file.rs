//! Files that are there as a whole or not at all.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

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
    /// Opens the temporary file, so that a place that cannot be written is known before the work is done.
    pub(crate) fn create(target: &Path) -> Result<Self, Failure> {
        let shown = target.display();
        // A link is followed: what it points to is replaced, not the link.
        let target = fs::canonicalize(target).unwrap_or_else(|_| target.to_owned());
        if let Ok(found) = fs::metadata(&target)
            && !found.is_file()
        {
            let kind = if found.is_dir() { "a directory" } else { "no regular file" };
            return Err(Failure::new(format!("cannot write {shown}: it is {kind}")));
        }
        let Some(name) = target.file_name() else {
            return Err(Failure::new(format!("cannot write {shown}: it has no file name")));
        };
        // The extension last, as it says which format is meant.
        let (name, process) = (name.to_string_lossy(), std::process::id());
        let temporary = target.with_file_name(format!(".unfinished.{process}.{name}"));
        let file = File::create(&temporary).context(format!("cannot write {shown}"))?;
        Ok(Self { target, temporary, writer: Some(BufWriter::new(file)) })
    }

    /// Where it is until then, for those who write a whole file by name.
    pub(crate) fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Puts the finished file in its place.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        let target = self.target.clone();
        self.rename_to(target)
    }

    /// Puts an unfinished file beside its place, as NAME.partial.EXTENSION; a file at its place stays.
    pub(crate) fn finish_partial(self) -> Result<PathBuf, Failure> {
        let extension =
            self.target.extension().map_or_else(String::new, |e| e.to_string_lossy().into_owned());
        let target = self.target.with_extension(format!("partial.{extension}"));
        self.rename_to(target)
    }

    fn rename_to(mut self, target: PathBuf) -> Result<PathBuf, Failure> {
        let written = self.flush().and_then(|()| {
            self.writer = None;
            fs::rename(&self.temporary, &target)
        });
        written.context(format!("cannot write {}", target.display()))?;
        Ok(target)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.write(bytes))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for WholeFile {
    /// Given up: nothing is left. After a rename there is nothing of that name.
    fn drop(&mut self) {
        self.writer = None;
        let _ = fs::remove_file(&self.temporary);
    }
}
