//! Where an output goes, and that it goes over no input and no other output.

use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

use robot_dynamics::output::{is_same_file, resolve};

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

/// Refuses an output that is a file which was read or another output, by whatever name or link. The file that an output
/// leaves when it cannot be finished counts as well; what is no file (`-` of a terminal, `/dev/null`, a pipe) clashes with
/// nothing. `robot` is the file of the command line, `read` are all files that the robot comes from.
pub(crate) fn refuse_clashes(robot: &Path, read: &[PathBuf], outputs: &[Named<'_>]) -> Result<(), Failure> {
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
                    "{role} {shown} would be kept as {kept} if the run ended early, and that is {other}, {name}; name \
                     another file"
                )
            } else {
                format!("{role} {shown} is the same file as {other}, {name}; name another file")
            }));
        }
        taken.extend(places.into_iter().map(|place| (role, shown.to_string(), place)));
    }
    Ok(())
}

/// A stream that the shell has opened on a file of the disk.
fn on_disk(stream: &Path) -> Option<PathBuf> {
    fs::metadata(stream).is_ok_and(|found| found.is_file()).then(|| stream.to_owned())
}

/// Whether a path ends in `/` or in `/.`, and so can only be a directory.
fn ends_in_separator(path: &Path) -> bool {
    path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
        || matches!(path.components().next_back(), Some(Component::ParentDir | Component::CurDir))
}
