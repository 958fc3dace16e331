//! The folder of the tree.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Another tree that is read instead of the repository.
pub(crate) static OTHER_TREE: OnceLock<PathBuf> = OnceLock::new();

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    let own = || Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the root").into();
    OTHER_TREE.get().cloned().unwrap_or_else(own)
}
