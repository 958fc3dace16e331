//! The folder of the tree.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Another tree that is read instead of the repository.
pub(crate) static OTHER_TREE: OnceLock<PathBuf> = OnceLock::new();

/// The repository's root: the one in which Cargo runs this program. A program in a target folder that several
/// work trees share may come from another one.
pub(crate) fn root() -> PathBuf {
    let own = || {
        let running = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
        let running = running.filter(|folder| folder.ends_with("xtask"));
        let folder = running.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).into());
        folder.parent().expect("xtask lies in the root").into()
    };
    OTHER_TREE.get().cloned().unwrap_or_else(own)
}
