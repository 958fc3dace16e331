//! Destinations of outputs, and the check that no output replaces an input or another output.

use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

use robot_dynamics::output::{is_same_file, resolve};

use crate::failure::{Context, Failure};

/// The destination of an output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Destination {
    /// Standard output: `-` or `/dev/stdout`.
    StandardOutput,
    /// A device, a pipe, or a file that the shell has opened.
    Stream(PathBuf),
    /// A file, existing or new; links are followed.
    File(PathBuf),
}

impl Destination {
    /// Interprets `path` as an output.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        let is_one_of = |names: &[&str]| names.iter().any(|name| path == Path::new(name));
        if is_one_of(&["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]) {
            return Ok(Self::StandardOutput);
        }
        // A descriptor of the shell is a stream, whatever it points to.
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
                Err(Failure::new(format!("cannot write {shown}: the path has no file name")))
            }
            _ => Ok(Self::File(resolved)),
        }
    }
}

/// The path of an unfinished file: NAME.partial.EXTENSION, or NAME.partial without an extension.
pub(crate) fn partial(path: &Path) -> PathBuf {
    let extension = path.extension().map(OsStr::to_string_lossy);
    path.with_extension(extension.map_or_else(|| "partial".into(), |e| format!("partial.{e}")))
}

/// A path for a message, relative to the current folder if possible.
pub(crate) fn shown(path: &Path) -> PathBuf {
    let inside = fs::canonicalize(".").ok().and_then(|here| Some(path.strip_prefix(here).ok()?.to_owned()));
    inside.unwrap_or_else(|| path.to_owned())
}

/// A path of the command line with its role in a message: `--csv`, `the robot's file`.
pub(crate) type NamedPath<'a> = (&'a str, &'a Path);

/// Rejects an output that is an input file or another output, under any name or link. The partial file of an
/// unfinished output counts as well. Devices and pipes clash with nothing. `robot` is the file of the command
/// line, `read` are all files that the robot is read from.
pub(crate) fn refuse_clashes(
    robot: &Path,
    read: &[PathBuf],
    outputs: &[NamedPath<'_>],
) -> Result<(), Failure> {
    let mut taken: Vec<(&str, String, PathBuf)> =
        vec![("the robot's file", robot.display().to_string(), robot.to_owned())];
    let own = |file: &PathBuf| {
        ("a file that the robot is read from", shown(file).display().to_string(), file.clone())
    };
    taken.extend(read.iter().map(own));
    for &(role, path) in outputs {
        let places = match Destination::of(path)? {
            Destination::StandardOutput => on_disk(Path::new("/dev/stdout")).into_iter().collect(),
            Destination::Stream(place) => on_disk(&place).into_iter().collect(),
            Destination::File(file) => vec![file.clone(), partial(&file)],
        };
        let shown = path.display();
        for (place, is_partial) in places.iter().zip([false, true]) {
            let Some((other, name, _)) = taken.iter().find(|(.., other)| is_same_file(place, other)) else {
                continue;
            };
            return Err(Failure::new(if is_partial {
                let kept = partial(path);
                let kept = kept.display();
                format!(
                    "{role} {shown} would become {kept} if the run ended early, which is {other}, {name}; choose \
                     another file"
                )
            } else {
                format!("{role} {shown} is the same file as {other}, {name}; choose another file")
            }));
        }
        taken.extend(places.into_iter().map(|place| (role, shown.to_string(), place)));
    }
    Ok(())
}

/// The stream's path, if the shell has opened it on a regular file.
fn on_disk(stream: &Path) -> Option<PathBuf> {
    fs::metadata(stream).is_ok_and(|found| found.is_file()).then(|| stream.to_owned())
}

/// Whether a path ends in a separator, `.` or `..`, and can only be a directory.
fn ends_in_separator(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
        || matches!(path.components().next_back(), Some(Component::ParentDir | Component::CurDir))
}
