//! Files that a program writes: over none that was read, and all of them or none.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether two paths are the same file: by device and inode where both are there and the system has them, so that
/// symbolic and hard links are seen through; else by their folder, links followed, and their name.
/// Names that differ in capitals alone count as one, as they are on some systems.
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

/// The first of the files that were read that a destination would replace, by whatever path or link.
/// `files` are [`LoadReport::files`](crate::LoadReport::files), for one.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// use robot_dynamics::output::file_read_at;
/// let robot = robot_dynamics::load(file)?;
/// assert_eq!(file_read_at(file, &robot.report.files), Some(&*robot.report.files[0]));
/// assert_eq!(file_read_at("to_come.urdf", &robot.report.files), None);
/// # Ok::<(), robot_dynamics::LoadError>(())
/// ```
pub fn file_read_at(destination: impl AsRef<Path>, files: &[PathBuf]) -> Option<&Path> {
    let destination = identity(destination.as_ref());
    files.iter().map(PathBuf::as_path).find(|file| identity(file) == destination)
}

/// The identity of a file: two paths with the same identity are the same file.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    /// A file that is there: device and inode.
    #[cfg(unix)]
    Found(u64, u64),
    /// A file to come, or one on a system without inodes: its folder as the system names it, and its name.
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
///
/// ```
/// use robot_dynamics::output::resolve;
/// assert_eq!(resolve("./to_come.csv".as_ref())?, std::env::current_dir()?.canonicalize()?.join("to_come.csv"));
/// assert!(resolve("nowhere/to_come.csv".as_ref()).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// The folder is not there, or links lead to one another.
pub fn resolve(path: &Path) -> io::Result<PathBuf> {
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
    Err(io::Error::other("too many links, one leading to the other"))
}

/// A new file beside `target`, to be renamed when it is complete: `.unfinished.PROCESS.NAME`. A file of that name, left
/// by a run that was killed, is not touched.
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
/// No file can be made there.
pub fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    let open = |path: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(path);
    beside(target, "unfinished", open)
}

/// Does something with a name beside `target` that no file has.
fn beside<T>(target: &Path, word: &str, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut attempt = 0;
    loop {
        let again = if attempt == 0 { String::new() } else { format!("-{attempt}") };
        // The extension last, as it says which format is meant.
        let path = target.with_file_name(format!(".{word}.{process}{again}.{name}"));
        match make(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
            made => return made.map(|made| (path, made)),
        }
    }
}

/// Puts complete files in their places: all of them, or none. Each pair is the file as it is named now and its place,
/// on the same file system; a file at a place is replaced. After an error the older files are in their places again.
///
/// ```
/// use robot_dynamics::output::replace_all;
/// let folder = std::env::temp_dir().join("robot_dynamics_replace_all");
/// std::fs::create_dir_all(folder.join("taken"))?; // a folder, which no file replaces
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
/// The system's, for the first file that cannot be put in its place.
pub fn replace_all(files: &[(PathBuf, PathBuf)]) -> io::Result<()> {
    let mut replaced: Vec<(&Path, &Path, Option<PathBuf>)> = Vec::new();
    let mut replace = |temporary, target| {
        let older = keep_older(target)?;
        if let Err(error) = fs::rename(temporary, target) {
            older.map_or(Ok(()), |older| fs::rename(older, target))?;
            return Err(error);
        }
        replaced.push((temporary, target, older));
        Ok(())
    };
    // The last file, and so one alone, needs no older one kept: nothing can fail after it.
    let Some(((temporary, target), before)) = files.split_last() else { return Ok(()) };
    let done = before.iter().try_for_each(|(temporary, target)| replace(temporary, target));
    if let Err(error) = done.and_then(|()| fs::rename(temporary, target)) {
        for (temporary, target, older) in replaced.into_iter().rev() {
            // As far as the system lets it; the error is the first one.
            let _ = fs::rename(target, temporary);
            let _ = older.map(|older| fs::rename(older, target));
        }
        return Err(error);
    }
    replaced.into_iter().filter_map(|(.., older)| older).for_each(|older| drop(fs::remove_file(older)));
    Ok(())
}

/// Keeps the file at a place under a second name beside it; `None` where there is no file.
fn keep_older(target: &Path) -> io::Result<Option<PathBuf>> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
        Ok(found) if found.is_dir() => {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        Ok(_) => {}
    }
    // By a hard link the file is at its place until the new one is. Some file systems have none: a copy then.
    let kept = beside(target, "older", |path| fs::hard_link(target, path)).map(|(older, ())| older);
    let copy = |path: &Path| {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        io::copy(&mut File::open(target)?, &mut file).map(drop)
    };
    kept.or_else(|_| beside(target, "older", copy).map(|(older, ())| older)).map(Some)
}

/// Writes several files, all of them or none; folders are made where they are missing. A file that is there is replaced when
/// all are complete, and keeps its permissions. Links to files are followed.
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
/// [`NotWritten`] names the first file that cannot be written; nothing has changed then.
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

/// A file that could not be written; no other was written either.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {cause}", path.display())]
#[non_exhaustive]
pub struct NotWritten {
    /// The file.
    pub path: PathBuf,
    /// Why not.
    pub cause: io::Error,
}

/// Files under temporary names, and folders made for them; removed when it is dropped, unless they have been renamed.
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
                io::Error::new(error.kind(), format!("cannot make the folder {}: {error}", folder.display()))
            };
            fs::create_dir_all(folder).map_err(named)?;
        }
        let target = resolve(path)?;
        let older = fs::metadata(&target).ok();
        if older.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        if older.is_some() {
            OpenOptions::new().write(true).open(&target)?;
        }
        let (temporary, mut file) = create_beside(&target)?;
        self.files.push((temporary.clone(), target));
        file.write_all(content)?;
        file.flush()?;
        older.map_or(Ok(()), |older| fs::set_permissions(&temporary, older.permissions()))
    }
}

impl Drop for Temporaries {
    fn drop(&mut self) {
        // After a rename there is nothing of that name.
        self.files.iter().for_each(|(temporary, _)| drop(fs::remove_file(temporary)));
        // The innermost first; one that holds something else stays.
        self.folders.sort_by_key(|folder| std::cmp::Reverse(folder.components().count()));
        self.folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}
