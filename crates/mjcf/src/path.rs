//! Paths of files that an MJCF file names.

use std::path::{Component, Path, PathBuf};

/// A relative path without `.` and `..`; `None` for a path that is absolute or begins outside.
pub(crate) fn normalize(path: &Path) -> Option<PathBuf> {
    let clean = simplify(path);
    clean.components().all(|component| matches!(component, Component::Normal(_))).then_some(clean)
}

/// A path without `.`, and with `..` only at its beginning.
pub(crate) fn simplify(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => match clean.components().next_back() {
                Some(Component::Normal(_)) => {
                    clean.pop();
                }
                Some(Component::RootDir) => {}
                _ => clean.push(component),
            },
            _ => clean.push(component),
        }
    }
    clean
}

/// The name of a file without folder and extension.
pub(crate) fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_simplified() {
        for (path, simple) in [
            ("a/./b/../c", "a/c"),
            ("../a/../../b", "../../b"),
            ("a/..", ""),
            ("/a/../../b", "/b"),
            ("./a", "a"),
        ] {
            assert_eq!(simplify(Path::new(path)), Path::new(simple), "{path}");
        }
        assert_eq!(normalize(Path::new("a/../../b")), None);
        assert_eq!(normalize(Path::new("/a")), None);
    }
}
