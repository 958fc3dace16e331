//! Writes output files: no input is overwritten, and either all files are written or none.

use robot_dynamics_number::{Classified, ErrorKind};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether two paths are the same file. Existing files are compared by device and inode on systems that have
/// them, which follows symbolic and hard links. Other paths are compared by resolved folder and name. Names
/// that differ only in upper and lower case count as equal, as on some systems.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// # let other = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/../robots/two_r.urdf");
/// use robot_dynamics::output::is_same_file;
/// assert!(is_same_file(file, other) && is_same_file("to_come.csv", "./to_come.csv"));
/// assert!(!is_same_file(file, "to_come.csv"));
/// ```
pub fn is_same_file(one: impl AsRef<Path>, other: impl AsRef<Path>) -> bool {
    identity(one.as_ref()) == identity(other.as_ref())
}

/// The first file that a destination would replace, among files that were read. `files` can be
/// [`LoadReport::files`](crate::description::LoadReport::files).
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// use robot_dynamics::output::file_read_at;
/// let robot = robot_dynamics::load(file)?;
/// assert_eq!(file_read_at(file, &robot.report.files), Some(&*robot.report.files[0]));
/// assert_eq!(file_read_at("to_come.urdf", &robot.report.files), None);
/// # Ok::<(), robot_dynamics::Error>(())
/// ```
pub fn file_read_at(destination: impl AsRef<Path>, files: &[PathBuf]) -> Option<&Path> {
    let destination = identity(destination.as_ref());
    files.iter().map(PathBuf::as_path).find(|file| identity(file) == destination)
}

/// The identity of a file: two paths with the same identity are the same file.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    /// An existing file: device and inode.
    #[cfg(unix)]
    Inode(u64, u64),
    /// A missing file, or one on a system without inodes: its resolved folder, and its name in lower case.
    Name(PathBuf, String),
}

fn identity(path: &Path) -> Identity {
    #[cfg(unix)]
    if let Ok(found) = fs::metadata(path) {
        use std::os::unix::fs::MetadataExt;
        return Identity::Inode(found.dev(), found.ino());
    }
    let resolved = resolve(path).unwrap_or_else(|_| path.to_owned());
    let name = resolved.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    Identity::Name(resolved.parent().map_or_else(PathBuf::new, Path::to_owned), name)
}

/// The absolute path with symbolic links resolved. The file itself need not exist.
///
/// ```
/// use robot_dynamics::output::resolve;
/// assert_eq!(resolve("./to_come.csv".as_ref())?, std::env::current_dir()?.canonicalize()?.join("to_come.csv"));
/// assert!(resolve("nowhere/to_come.csv".as_ref()).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// The folder does not exist, or links form a cycle.
pub fn resolve(path: &Path) -> io::Result<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Ok(found);
    }
    let mut path = path.to_owned();
    // Linux follows as many links.
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
    Err(io::Error::other("too many symbolic links"))
}

/// Creates a temporary file beside `target`, to be renamed when it is complete: `.unfinished.PROCESS.NAME`.
/// An existing file of that name, for example of a run that was killed, is not changed.
///
/// ```
/// use robot_dynamics::output::create_beside;
/// let target = std::env::temp_dir().join("robot_dynamics_beside.csv");
/// let (temporary, file) = create_beside(&target)?;
/// assert!(temporary.is_file() && temporary.parent() == target.parent());
/// drop(file);
/// std::fs::remove_file(temporary)?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// The file cannot be created.
pub fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    let open = |path: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(path);
    create_unique(target, "unfinished", open)
}

/// Calls `make` with an unused path beside `target`.
fn create_unique<T>(
    target: &Path,
    word: &str,
    make: impl Fn(&Path) -> io::Result<T>,
) -> io::Result<(PathBuf, T)> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut attempt = 0;
    loop {
        let again = if attempt == 0 { String::new() } else { format!("-{attempt}") };
        // The extension stays at the end, because it gives the format.
        let path = target.with_file_name(format!(".{word}.{process}{again}.{name}"));
        match make(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
            made => return made.map(|made| (path, made)),
        }
    }
}

/// Renames complete files to their destinations: all of them, or none. Each pair is a temporary file and its
/// destination on the same file system. Existing files are replaced, and restored after an error.
///
/// ```
/// use robot_dynamics::output::replace_all;
/// let folder = std::env::temp_dir().join("robot_dynamics_replace_all");
/// std::fs::create_dir_all(folder.join("taken"))?; // a folder cannot be replaced by a file
/// let [new, place] = ["new.csv", "run.csv"].map(|name| folder.join(name));
/// std::fs::write(&new, "new")?;
/// std::fs::write(&place, "older")?;
/// assert!(replace_all(&[(new.clone(), place.clone()), (new.clone(), folder.join("taken"))]).is_err());
/// assert_eq!(std::fs::read_to_string(&place)?, "older");
/// replace_all(&[(new, place.clone())])?;
/// assert_eq!(std::fs::read_to_string(&place)?, "new");
/// # std::fs::remove_dir_all(folder)?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// The system's error for the first file that cannot be renamed.
pub fn replace_all(files: &[(PathBuf, PathBuf)]) -> io::Result<()> {
    let mut replaced: Vec<(&Path, &Path, Option<PathBuf>)> = Vec::new();
    let mut replace = |temporary, target| {
        let backup = back_up(target)?;
        if let Err(error) = fs::rename(temporary, target) {
            backup.map_or(Ok(()), |backup| fs::rename(backup, target))?;
            return Err(error);
        }
        replaced.push((temporary, target, backup));
        Ok(())
    };
    // The last rename needs no backup, because nothing can fail after it.
    let Some(((temporary, target), before)) = files.split_last() else { return Ok(()) };
    let done = before.iter().try_for_each(|(temporary, target)| replace(temporary, target));
    if let Err(error) = done.and_then(|()| fs::rename(temporary, target)) {
        for (temporary, target, backup) in replaced.into_iter().rev() {
            // Restores as far as possible, and returns the first error.
            let _ = fs::rename(target, temporary);
            let _ = backup.map(|backup| fs::rename(backup, target));
        }
        return Err(error);
    }
    replaced.into_iter().filter_map(|(.., backup)| backup).for_each(|backup| drop(fs::remove_file(backup)));
    Ok(())
}

/// Backs up an existing file under another name beside it; `None` if there is no file.
fn back_up(target: &Path) -> io::Result<Option<PathBuf>> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
        Ok(found) if found.is_dir() => {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        Ok(_) => {}
    }
    // With a hard link the file stays at its destination until it is replaced. A copy serves where links are
    // unsupported.
    let linked =
        create_unique(target, "older", |path| fs::hard_link(target, path)).map(|(backup, ())| backup);
    let copy = |path: &Path| {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        io::copy(&mut File::open(target)?, &mut file).map(drop)
    };
    linked.or_else(|_| create_unique(target, "older", copy).map(|(backup, ())| backup)).map(Some)
}

/// Writes several files: all of them, or none. Missing folders are created. Existing files are replaced when
/// all new files are complete, and keep their permissions. Symbolic links are followed.
///
/// ```
/// use robot_dynamics::output::write_files;
/// let folder = std::env::temp_dir().join("robot_dynamics_write_files");
/// write_files(&[(folder.join("a/one.txt"), "1"), (folder.join("two.txt"), "2")])?;
/// assert_eq!(std::fs::read_to_string(folder.join("a/one.txt"))?, "1");
/// # std::fs::remove_dir_all(folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`NotWritten`] names the first file that cannot be written. Nothing is changed in this case.
pub fn write_files<T: AsRef<[u8]>>(files: &[(PathBuf, T)]) -> Result<(), NotWritten> {
    let mut written = Temporaries::default();
    let done = files.iter().try_for_each(|(path, content)| {
        written.add(path, content.as_ref()).map_err(|cause| NotWritten { path: path.clone(), cause })
    });
    let done = done.and_then(|()| {
        let first = || files.first().map(|(path, _)| path.clone()).unwrap_or_default();
        replace_all(&written.files).map_err(|cause| NotWritten { path: first(), cause })
    });
    if done.is_ok() {
        written.folders.clear();
    }
    done
}

/// A file that cannot be written. No other file was written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {cause}", path.display())]
#[non_exhaustive]
pub struct NotWritten {
    /// The file.
    pub path: PathBuf,
    /// The cause.
    pub cause: io::Error,
}

impl Classified for NotWritten {
    fn kind(&self) -> ErrorKind {
        ErrorKind::File
    }
}

/// Temporary files, and folders that were created for them. Drop removes those that have not been renamed.
#[derive(Default)]
struct Temporaries {
    files: Vec<(PathBuf, PathBuf)>,
    folders: Vec<PathBuf>,
}

impl Temporaries {
    fn add(&mut self, path: &Path, content: &[u8]) -> io::Result<()> {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            let missing =
                folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
            self.folders.extend(missing.map(Path::to_owned));
            let named = |error: io::Error| {
                io::Error::new(
                    error.kind(),
                    format!("cannot create the folder {}: {error}", folder.display()),
                )
            };
            fs::create_dir_all(folder).map_err(named)?;
        }
        let target = resolve(path)?;
        let existing = fs::metadata(&target).ok();
        if existing.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        if existing.is_some() {
            OpenOptions::new().write(true).open(&target)?;
        }
        let (temporary, mut file) = create_beside(&target)?;
        self.files.push((temporary.clone(), target));
        file.write_all(content)?;
        file.flush()?;
        existing.map_or(Ok(()), |existing| fs::set_permissions(&temporary, existing.permissions()))
    }
}

impl Drop for Temporaries {
    fn drop(&mut self) {
        // A renamed file no longer has its temporary name.
        self.files.iter().for_each(|(temporary, _)| drop(fs::remove_file(temporary)));
        // The innermost folder first. A folder that is not empty stays.
        self.folders.sort_by_key(|folder| std::cmp::Reverse(folder.components().count()));
        self.folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}
