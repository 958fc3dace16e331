//! Where an output goes, and that it goes over no input and no other output.

use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::failure::{Context, Failure};

/// Where an output goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Destination {
    /// To whoever reads what the command prints: `-` or `/dev/stdout`.
    StandardOutput,
    /// Straight there: a device, a pipe, a file that the shell holds open.
    Stream(PathBuf),
    /// To a file, there or to come; links are followed.
    File(PathBuf),
}

impl Destination {
    /// What `path` means as an output.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        let is_one_of = |names: &[&str]| names.iter().any(|name| path == Path::new(name));
        if is_one_of(&["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]) {
            return Ok(Self::StandardOutput);
        }
        // What the shell holds open belongs to it, whatever stands behind it.
        if path == Path::new("/dev/stderr")
            || path.starts_with("/dev/fd")
            || path.starts_with("/proc/self/fd")
        {
            return Ok(Self::Stream(path.to_owned()));
        }
        let resolved = resolve(path).context(format!("cannot write {shown}"))?;
        match fs::metadata(&resolved) {
            Ok(found) if found.is_dir() => {
                Err(Failure::new(format!("cannot write {shown}: it is a directory")))
            }
            Ok(found) if !found.is_file() => Ok(Self::Stream(resolved)),
            _ if resolved.file_name().is_none() || ends_in_separator(path) => {
                Err(Failure::new(format!("cannot write {shown}: it has no file name")))
            }
            _ => Ok(Self::File(resolved)),
        }
    }
}

/// Where a file is kept that could not be finished: NAME.partial.EXTENSION, or NAME.partial without one.
pub(crate) fn partial(path: &Path) -> PathBuf {
    let extension = path.extension().map(OsStr::to_string_lossy);
    path.with_extension(extension.map_or_else(|| "partial".into(), |e| format!("partial.{e}")))
}

/// A path as a message shows it: without the present folder.
pub(crate) fn shown(path: &Path) -> PathBuf {
    let inside = fs::canonicalize(".").ok().and_then(|here| Some(path.strip_prefix(here).ok()?.to_owned()));
    inside.unwrap_or_else(|| path.to_owned())
}

/// A file of a command line, with what a message calls it: `--csv`, `the robot's file`.
pub(crate) type Named<'a> = (&'a str, &'a Path);

/// Refuses an output that is an input or another output, by whatever name or link. The file that an output leaves
/// when it cannot be finished counts as well; what is no file (`-`, `/dev/null`, a pipe) clashes with nothing.
pub(crate) fn refuse_clashes(inputs: &[Named<'_>], outputs: &[Named<'_>]) -> Result<(), Failure> {
    let is_input = |&(role, path): &Named<'_>| (role.to_owned(), path.display().to_string(), identity(path));
    let mut taken: Vec<_> = inputs.iter().map(is_input).collect();
    for &(role, path) in outputs {
        let Destination::File(file) = Destination::of(path)? else { continue };
        let kept = partial(&file);
        let shown = path.display();
        for (place, is_partial) in [(&file, false), (&kept, true)] {
            let identity = identity(place);
            let Some((other, name, _)) = taken.iter().find(|(.., other)| *other == identity) else {
                continue;
            };
            return Err(Failure::new(if is_partial {
                let kept = partial(path);
                let kept = kept.display();
                format!(
                    "{role} {shown} would be kept as {kept} if the run ended early, and that is {other}, {name}; name \
                     another file"
                )
            } else {
                format!("{role} {shown} is the same file as {other}, {name}; name another file")
            }));
        }
        for place in [&file, &kept] {
            taken.push((role.to_owned(), shown.to_string(), identity(place)));
        }
    }
    Ok(())
}

/// What makes two paths the same file.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    /// A file that is there: device and inode.
    #[cfg(unix)]
    Found(u64, u64),
    /// A file to come, or one on a system without inodes: its folder as the system names it, and its name. Names that
    /// differ in capitals alone are one file on some systems.
    Name(PathBuf, String),
}

fn identity(path: &Path) -> Identity {
    #[cfg(unix)]
    if let Ok(found) = fs::metadata(path) {
        use std::os::unix::fs::MetadataExt;
        return Identity::Found(found.dev(), found.ino());
    }
    let resolved = resolve(path).unwrap_or_else(|_| path.to_owned());
    let name = resolved.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    Identity::Name(resolved.parent().map_or_else(PathBuf::new, Path::to_owned), name)
}

/// The path with its folder as the system names it and links followed, also one that leads to a file to come.
fn resolve(path: &Path) -> std::io::Result<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Ok(found);
    }
    let mut path = path.to_owned();
    // As many links as Linux follows.
    for _ in 0..40 {
        let folder = match path.parent() {
            Some(folder) if folder.as_os_str().is_empty() => Path::new("."),
            Some(folder) => folder,
            None => return Ok(path),
        };
        let folder = fs::canonicalize(folder)?;
        match fs::read_link(&path) {
            Ok(target) => path = folder.join(target),
            Err(_) => return Ok(path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))),
        }
    }
    Err(std::io::Error::other("too many links, one leading to the other"))
}

/// Whether a path ends in `/` or in `/.`, and so can only be a directory.
fn ends_in_separator(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
        || matches!(path.components().next_back(), Some(Component::ParentDir | Component::CurDir))
}
