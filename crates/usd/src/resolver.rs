//! Files of a stage: from the disk or from memory, with limits.

use std::cell::RefCell;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use openusd::ar::{self, Asset, ResolvedPath, Resolver};
use robot_dynamics_xml::{Budget, Resource, SIZE_LIMIT};

use crate::scan;

/// The state that the resolver shares with the reader.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) budget: Budget,
    /// The number of bytes of all files.
    pub(crate) bytes: usize,
    /// The files that were opened.
    pub(crate) files: Vec<PathBuf>,
    /// Reasons for which files were refused.
    pub(crate) refused: Vec<String>,
}

/// Opens the main file from its content, and other files from the disk, or from memory.
pub(crate) struct BoundedResolver {
    pub(crate) main: PathBuf,
    pub(crate) content: Vec<u8>,
    /// The folder that other files must be in.
    pub(crate) root: Option<PathBuf>,
    /// All files, if none is on the disk.
    pub(crate) in_memory: Option<Vec<(PathBuf, Vec<u8>)>>,
    pub(crate) shared: Rc<RefCell<Shared>>,
}

/// Removes `.` and, where a folder precedes it, `..`.
pub(crate) fn plain(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(result.components().next_back(), Some(Component::Normal(_))) => {
                result.pop();
            }
            part => result.push(part),
        }
    }
    result
}

impl BoundedResolver {
    fn refuse(&self, reason: String) -> io::Error {
        self.shared.borrow_mut().refused.push(reason.clone());
        io::Error::other(reason)
    }

    /// The content of a file that is not in an archive.
    fn bytes(&self, path: &Path) -> io::Result<Vec<u8>> {
        if path == self.main {
            return Ok(self.content.clone());
        }
        if let Some(files) = &self.in_memory {
            let found = files.iter().find(|(name, _)| name == path);
            let found = found.ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
            return Ok(found.1.clone());
        }
        if let Some(root) = &self.root
            && !path.starts_with(root)
        {
            let (path, root) = (path.display(), root.display());
            return Err(
                self.refuse(format!("{path} is outside the folder {root}, to which the reading is confined"))
            );
        }
        if !std::fs::metadata(path)?.is_file() {
            return Err(self.refuse(format!("{} is not a regular file", path.display())));
        }
        let mut bytes = Vec::new();
        let file = std::fs::File::open(path)?;
        io::Read::read_to_end(&mut io::Read::take(file, SIZE_LIMIT as u64 + 1), &mut bytes)?;
        Ok(bytes)
    }

    /// The content of a file of a stage, which may be in an archive.
    fn content_of(&self, path: &str) -> io::Result<Vec<u8>> {
        let bytes = match ar::split_package_relative_path_outer(path) {
            Some((archive, inner)) if ar::is_package_relative_path(path) => {
                unpack(&self.bytes(Path::new(&archive))?, &inner)?
            }
            _ => self.bytes(Path::new(path))?,
        };
        if bytes.len() > SIZE_LIMIT {
            return Err(self.refuse(format!("{path} has more than {SIZE_LIMIT} bytes")));
        }
        self.shared.borrow_mut().bytes += bytes.len();
        let charged = self.shared.borrow_mut().budget.charge(Resource::Characters, bytes.len());
        charged.map_err(|limit| self.refuse(format!("more than {} {}", limit.limit, limit.what)))?;
        scan::check(&bytes).map_err(|reason| self.refuse(format!("{path}: {reason}")))?;
        Ok(bytes)
    }

    /// Whether there is a file of this name.
    fn exists(&self, path: &Path) -> bool {
        if path == self.main {
            return true;
        }
        match &self.in_memory {
            Some(files) => files.iter().any(|(name, _)| name == path),
            None => path.is_file(),
        }
    }

    /// The absolute path of a file on the disk, or the plain path of one in memory.
    fn canonical(&self, path: &Path) -> PathBuf {
        if path == self.main || self.in_memory.is_some() {
            return plain(path);
        }
        path.canonicalize().unwrap_or_else(|_| plain(path))
    }
}

/// A file in an archive, which may be in a further archive.
fn unpack(archive: &[u8], inner: &str) -> io::Result<Vec<u8>> {
    let (name, rest) = match ar::split_package_relative_path_outer(inner) {
        Some((name, rest)) if ar::is_package_relative_path(inner) => (name, Some(rest)),
        _ => (inner.to_owned(), None),
    };
    let mut archive = zip::ZipArchive::new(io::Cursor::new(archive)).map_err(io::Error::other)?;
    let entry = archive.by_name(&name).map_err(io::Error::other)?;
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut io::Read::take(entry, SIZE_LIMIT as u64 + 1), &mut bytes)?;
    match rest {
        Some(rest) if bytes.len() <= SIZE_LIMIT && rest.len() < inner.len() => unpack(&bytes, &rest),
        _ => Ok(bytes),
    }
}

impl Resolver for BoundedResolver {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        if asset_path.is_empty() {
            return String::new();
        }
        let written = asset_path.replace('\\', "/");
        if ar::is_package_relative_path(&written)
            && let Some((archive, inner)) = ar::split_package_relative_path_outer(&written)
        {
            let archive = self.create_identifier(&archive, anchor);
            return ar::join_package_relative_path(&archive, &inner);
        }
        let anchor = anchor.map(|anchor| anchor.to_string_lossy().into_owned());
        let path = Path::new(&written);
        if let Some(anchor) = anchor.filter(|_| path.is_relative()) {
            if let Some((archive, inner)) = ar::split_package_relative_path_inner(&anchor)
                && ar::is_package_relative_path(&anchor)
            {
                let folder = Path::new(&inner).parent().unwrap_or(Path::new(""));
                let inner = plain(&folder.join(path));
                return ar::join_package_relative_path(&archive, &inner.to_string_lossy());
            }
            let folder = Path::new(&anchor).parent().unwrap_or(Path::new(""));
            return self.canonical(&folder.join(path)).to_string_lossy().into_owned();
        }
        self.canonical(path).to_string_lossy().into_owned()
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        if asset_path.is_empty() {
            return None;
        }
        if ar::is_package_relative_path(asset_path) {
            let (archive, _) = ar::split_package_relative_path_outer(asset_path)?;
            return self.exists(Path::new(&archive)).then(|| ResolvedPath::new(asset_path));
        }
        let path = self.canonical(Path::new(asset_path));
        self.exists(&path).then(|| ResolvedPath::new(path))
    }

    fn resolve_for_new_asset(&self, _asset_path: &str) -> Option<ResolvedPath> {
        None
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let path = resolved_path.to_string_lossy();
        let bytes = self.content_of(&path)?;
        let outer =
            ar::split_package_relative_path_outer(&path).map_or(path.into_owned(), |(archive, _)| archive);
        self.shared.borrow_mut().files.push(outer.into());
        Ok(Box::new(io::Cursor::new(bytes)))
    }

    fn get_modification_timestamp(
        &self,
        _asset_path: &str,
        _resolved_path: &ResolvedPath,
    ) -> Option<std::time::SystemTime> {
        None
    }
}
