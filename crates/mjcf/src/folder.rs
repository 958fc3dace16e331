//! Where the files are that a robot's file names: beside it on the disk, or in memory.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use robot_mesh::Triangles;

use crate::source::inside;

/// Files in memory by their relative paths, as a browser or an archive hands them over; clones share them.
///
/// ```
/// use mjcf::{FileSet, Options};
/// let files = FileSet::new([
///     ("ball/scene.xml", r#"<mujoco><include file="parts/ball.xml"/></mujoco>"#),
///     ("ball/parts/ball.xml", r#"<mujoco><worldbody><body name="ball"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"#),
/// ]);
/// let robot = mjcf::load_among(&files, "ball/scene.xml", &Options::default())?;
/// assert_eq!(robot.description.links[1].name, "ball");
/// # Ok::<(), mjcf::LoadError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct FileSet(Arc<BTreeMap<PathBuf, Vec<u8>>>);

impl FileSet {
    /// Of paths and contents; `.` and `..` in paths are followed.
    pub fn new<P: AsRef<Path>, C: Into<Vec<u8>>>(files: impl IntoIterator<Item = (P, C)>) -> Self {
        let mut all = Self::default();
        for (path, content) in files {
            all.insert(path, content);
        }
        all
    }

    /// With one more, in the place of one of that path. A path that leaves its start is nowhere: such a file is left out.
    pub fn insert(&mut self, path: impl AsRef<Path>, content: impl Into<Vec<u8>>) {
        if let Some(path) = inside(path.as_ref()) {
            Arc::make_mut(&mut self.0).insert(path, content.into());
        }
    }

    /// A file's content.
    pub fn get(&self, path: impl AsRef<Path>) -> Option<&[u8]> {
        self.0.get(&inside(path.as_ref())?).map(Vec::as_slice)
    }

    /// A file's text.
    ///
    /// # Errors
    /// It is not there, too large, or no text.
    pub(crate) fn text(&self, path: &Path) -> Result<String, robot_xml::XmlError> {
        let Some(bytes) = self.get(path) else {
            let source = std::io::Error::new(
                std::io::ErrorKind::NotFound,
                "it is not among the files that were given",
            );
            return Err(robot_xml::XmlError::Unreadable { path: path.to_owned(), source });
        };
        robot_xml::text_of(bytes)
    }
}

/// The main file's folder.
#[derive(Clone)]
pub(crate) struct Folder {
    path: PathBuf,
    /// `None`: on the disk.
    given: Option<FileSet>,
    /// The files on the disk that were opened by it, or by a clone.
    opened: Rc<RefCell<Vec<PathBuf>>>,
}

impl Folder {
    /// Of the file at that path.
    pub(crate) fn of(path: &Path, given: Option<&FileSet>) -> Self {
        Self {
            path: path.parent().unwrap_or(Path::new("")).to_owned(),
            given: given.cloned(),
            opened: Rc::default(),
        }
    }

    /// The path of a file in it.
    pub(crate) fn join(&self, name: &Path) -> PathBuf {
        self.path.join(name)
    }

    pub(crate) fn is_on_disk(&self) -> bool {
        self.given.is_none()
    }

    /// Whether there is an ordinary file of that path.
    pub(crate) fn has(&self, path: &Path) -> bool {
        self.given.as_ref().map_or_else(|| path.is_file(), |files| files.get(path).is_some())
    }

    /// The files on the disk that were opened, in their order.
    pub(crate) fn opened(&self) -> Vec<PathBuf> {
        self.opened.borrow().clone()
    }

    /// The text of the file at that path, or why there is none.
    pub(crate) fn text(&self, path: &Path) -> Result<String, String> {
        let read = || {
            self.opened.borrow_mut().push(path.to_owned());
            robot_xml::read_file(path)
        };
        let text = self.given.as_ref().map_or_else(read, |files| files.text(path));
        text.map_err(|error| error.to_string())
    }

    /// The mesh in the file at that path, or why there is none.
    pub(crate) fn mesh(&self, path: &Path, content_type: Option<&str>) -> Result<Triangles, String> {
        let Some(files) = &self.given else {
            self.opened.borrow_mut().push(path.to_owned());
            return robot_mesh::read(path, content_type);
        };
        let missing = || format!("{} is not among the files that were given", path.display());
        robot_mesh::parse(files.get(path).ok_or_else(missing)?, path, content_type)
    }
}
