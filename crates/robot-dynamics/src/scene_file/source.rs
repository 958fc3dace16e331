//! The files that a scene names: on the disk, or in memory.

use std::path::{Component, Path, PathBuf};

use robot_dynamics_mesh::Triangles;
use robot_dynamics_mjcf::FileSet;
use robot_dynamics_xml::spellings;

use crate::load::Content;

/// The place of a scene's file.
pub(crate) enum Source<'s> {
    /// A file on the disk. `root` is the folder to which reading is confined.
    Disk { path: PathBuf, root: Option<PathBuf> },
    /// A file in memory.
    Memory { files: &'s FileSet, path: PathBuf },
    /// A text without files.
    Text,
}

/// The message for a text that names a file.
const NO_FILES: &str =
    "a text has no folder in which files are searched; load the scene by its path, or give the files";

impl<'s> Source<'s> {
    /// The source of a scene's file on the disk.
    pub(crate) fn disk(path: &Path, confined: bool) -> Self {
        let root = confined.then(|| {
            let folder = folder_of(path);
            folder.canonicalize().unwrap_or(folder)
        });
        Source::Disk { path: path.to_owned(), root }
    }

    /// The path of the file, on the disk or in memory.
    pub(super) fn path(&self) -> Option<&Path> {
        match self {
            Self::Disk { path, .. } | Self::Memory { path, .. } => Some(path),
            Self::Text => None,
        }
    }

    /// The scene's name by its file.
    pub(super) fn name(&self) -> Option<String> {
        name_of(self.path()?)
    }

    /// A file that the scene names.
    pub(super) fn find(&self, name: &str) -> Result<Source<'s>, String> {
        match self {
            Self::Text => Err(NO_FILES.into()),
            Self::Memory { files, path } => {
                let folder = path.parent().unwrap_or(Path::new(""));
                let found = spellings(name).map(|name| normal(&folder.join(name)));
                let found = found.into_iter().find(|path| files.get(path).is_some());
                let path = found.ok_or("the file is not among the given files")?;
                Ok(Source::Memory { files, path })
            }
            Self::Disk { path, root } => {
                let folder = folder_of(path);
                let found = spellings(name).map(|name| folder.join(name)).find(|path| path.is_file());
                let path = found.ok_or_else(|| {
                    format!("the file was not found; its path is relative to {}", folder.display())
                })?;
                if let Some(root) = root
                    && !path.canonicalize().is_ok_and(|path| path.starts_with(root))
                {
                    return Err(format!("reading is confined to the folder {}", root.display()));
                }
                Ok(Source::Disk { path, root: root.clone() })
            }
        }
    }

    /// The content of this file.
    pub(super) fn content(&self) -> Result<Content, String> {
        match self {
            Self::Text => Err(NO_FILES.into()),
            Self::Disk { path, .. } => {
                let bytes =
                    robot_dynamics_xml::read_regular_bytes(path).map_err(|error| error.to_string())?;
                Content::of(&bytes).map_err(|error| error.to_string())
            }
            Self::Memory { files, path } => {
                let bytes = files.get(path).ok_or("the file is not among the given files")?;
                Content::of(bytes).map_err(|error| error.to_string())
            }
        }
    }

    /// The triangles of this mesh file.
    pub(super) fn mesh(&self) -> Result<Triangles, String> {
        match self {
            Self::Text => Err(NO_FILES.into()),
            Self::Disk { path, .. } => robot_dynamics_mesh::read(path, None),
            Self::Memory { files, path } => {
                let content = files.get(path).ok_or("the file is not among the given files")?;
                robot_dynamics_mesh::parse(content, path, None)
            }
        }
    }
}

fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    folder.to_owned()
}

/// A path without `.` and `..`, as files in memory are named.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if normal.pop() => {}
            other => normal.push(other),
        }
    }
    normal
}

/// The name of a scene from its file: `cell` of `cell.scene.xml`.
fn name_of(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?.split('.').next()?;
    (!name.is_empty()).then(|| name.to_owned())
}
