//! Access to the files that an MJCF file names, on the disk or in memory.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use robot_dynamics_mesh::Triangles;

use crate::path::{normalize, simplify};

/// Files in memory by their relative paths, for example from a browser or an archive. Clones share the
/// content.
///
/// ```
/// use robot_dynamics_mjcf::{FileSet, LoadOptions};
/// let files = FileSet::new([
///     ("ball/scene.xml", r#"<mujoco><include file="parts/ball.xml"/></mujoco>"#),
///     ("ball/parts/ball.xml", r#"<mujoco><worldbody><body name="ball"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"#),
/// ]);
/// let robot = robot_dynamics_mjcf::load_from_files(&files, "ball/scene.xml", &LoadOptions::default())?;
/// assert_eq!(robot.description.links[1].name, "ball");
/// # Ok::<(), robot_dynamics_mjcf::LoadError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct FileSet(Arc<BTreeMap<PathBuf, Vec<u8>>>);

impl FileSet {
    /// A set of paths with contents; `.` and `..` in paths are resolved.
    pub fn new<P: AsRef<Path>, C: Into<Vec<u8>>>(files: impl IntoIterator<Item = (P, C)>) -> Self {
        let mut all = Self::default();
        for (path, content) in files {
            all.insert(path, content);
        }
        all
    }

    /// Adds a file, or replaces the one at that path. A file whose path is absolute or begins outside (`..`)
    /// is ignored.
    pub fn insert(&mut self, path: impl AsRef<Path>, content: impl Into<Vec<u8>>) {
        if let Some(path) = normalize(path.as_ref()) {
            Arc::make_mut(&mut self.0).insert(path, content.into());
        }
    }

    /// All files, in the order of their paths.
    ///
    /// ```
    /// let files = robot_dynamics_mjcf::FileSet::new([("b.xml", ""), ("a.xml", "")]);
    /// assert_eq!(files.iter().next().map(|(path, _)| path.to_str()), Some(Some("a.xml")));
    /// ```
    pub fn iter(&self) -> impl Iterator<Item = (&Path, &[u8])> {
        self.0.iter().map(|(path, content)| (path.as_path(), content.as_slice()))
    }

    /// The content of a file.
    pub fn get(&self, path: impl AsRef<Path>) -> Option<&[u8]> {
        self.0.get(&normalize(path.as_ref())?).map(Vec::as_slice)
    }

    /// The text of a file.
    ///
    /// # Errors
    /// [`XmlError`](robot_dynamics_xml::XmlError) if the file is missing, too large, or not text.
    pub fn text(&self, path: &Path) -> Result<String, robot_dynamics_xml::XmlError> {
        let Some(bytes) = self.get(path) else {
            let source = std::io::Error::new(std::io::ErrorKind::NotFound, "it is not among the given files");
            return Err(robot_dynamics_xml::XmlError::Unreadable { path: path.to_owned(), source });
        };
        robot_dynamics_xml::text_of(bytes)
    }
}

/// The folder of the main file.
#[derive(Clone)]
pub(crate) struct Folder {
    path: PathBuf,
    /// The files in memory; `None` for a folder on the disk.
    given: Option<FileSet>,
    /// Whether files outside the folder are refused.
    confined: bool,
    /// The files on the disk that were opened through this folder or a clone.
    opened: Rc<RefCell<Vec<PathBuf>>>,
}

impl Folder {
    /// The folder of the file at that path.
    pub(crate) fn of(path: &Path, given: Option<&FileSet>, confined: bool) -> Self {
        Self {
            path: path.parent().unwrap_or(Path::new("")).to_owned(),
            given: given.cloned(),
            confined,
            opened: Rc::default(),
        }
    }

    /// The path of a file from its path relative to the folder.
    pub(crate) fn join(&self, name: &Path) -> PathBuf {
        simplify(&self.path.join(name))
    }

    /// Whether two paths are those of one file.
    pub(crate) fn identity(&self, path: &Path) -> PathBuf {
        if self.is_on_disk() {
            path.canonicalize().unwrap_or_else(|_| path.to_owned())
        } else {
            path.to_owned()
        }
    }

    /// The first of these paths, relative to the folder, at which there is a file; otherwise the first of
    /// all.
    pub(crate) fn locate(&self, candidates: impl IntoIterator<Item = PathBuf>) -> PathBuf {
        let paths: Vec<PathBuf> = candidates.into_iter().map(|path| simplify(&path)).collect();
        let found = paths.iter().find(|path| self.has(&self.join(path)));
        found.or(paths.first()).cloned().unwrap_or_default()
    }

    /// Checks that the file at that path may be read.
    fn check(&self, path: &Path) -> Result<(), String> {
        if self.is_on_disk() && !self.confined {
            return Ok(());
        }
        let root = if self.path == Path::new("") { Path::new(".") } else { &self.path };
        let is_inside = if self.is_on_disk() {
            let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
            // A missing file has no links.
            let file = path.canonicalize().or_else(|_| std::path::absolute(path).map(|path| simplify(&path)));
            let file = file.unwrap_or_else(|_| path.to_owned());
            file.starts_with(&root)
        } else {
            normalize(path).is_some()
        };
        if is_inside {
            return Ok(());
        }
        let place = if self.is_on_disk() {
            format!("the folder {}, to which reading is confined", root.display())
        } else {
            "the given files".to_owned()
        };
        Err(format!("it is outside {place}"))
    }

    /// Whether the file at that path is on the disk and may be read.
    pub(crate) fn allows(&self, path: &Path) -> bool {
        self.is_on_disk() && path.is_file() && self.check(path).is_ok()
    }

    pub(crate) fn is_on_disk(&self) -> bool {
        self.given.is_none()
    }

    /// Whether there is a regular file at that path.
    pub(crate) fn has(&self, path: &Path) -> bool {
        self.given.as_ref().map_or_else(|| path.is_file(), |files| files.get(path).is_some())
    }

    /// The files on the disk that were opened, in order.
    pub(crate) fn opened(&self) -> Vec<PathBuf> {
        self.opened.borrow().clone()
    }

    /// The text of the file at that path, or the reason of the failure.
    pub(crate) fn text(&self, path: &Path) -> Result<String, String> {
        self.check(path)?;
        let read = || {
            self.opened.borrow_mut().push(path.to_owned());
            robot_dynamics_xml::read_regular_file(path)
        };
        let text = self.given.as_ref().map_or_else(read, |files| files.text(path));
        text.map_err(|error| error.to_string())
    }

    /// The mesh in the file at that path, or the reason of the failure.
    pub(crate) fn mesh(&self, path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
        self.check(path)?;
        let Some(files) = &self.given else {
            self.opened.borrow_mut().push(path.to_owned());
            return robot_dynamics_mesh::read(path, content_type);
        };
        let missing = || format!("{} is not among the given files", path.display());
        robot_dynamics_mesh::parse(files.get(path).ok_or_else(missing)?, path, content_type)
    }
}
