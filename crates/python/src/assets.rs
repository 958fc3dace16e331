//! The files that the text of a robot names, from memory.

use std::path::PathBuf;

use pyo3::PyResult;
use pyo3::exceptions::PyValueError;
use pyo3::pybacked::PyBackedBytes;
use robot_dynamics::FileSet;

/// A set of a main file with this text, and of the files that it names; and the path of the main file.
pub(crate) fn file_set(text: &str, assets: Vec<(PathBuf, PyBackedBytes)>) -> PyResult<(FileSet, String)> {
    let mut files = FileSet::default();
    for (path, content) in assets {
        files.insert(&path, content.to_vec());
        if files.get(&path).is_none() {
            let path = path.display();
            return Err(PyValueError::new_err(format!(
                "assets: {path:?} is absolute, or begins with `..`; give the path relative to the text"
            )));
        }
    }
    let mut main = "text".to_owned();
    while files.get(&main).is_some() {
        main.push('_');
    }
    files.insert(&main, text);
    Ok((files, main))
}
