//! The files of a request.

use std::fs;
use std::path::{Path, PathBuf};

use robot_dynamics::output::{NotWritten, write_files};

use crate::{GenerateError, heading};

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GeneratedFile {
    /// Its name, with slashes between folders.
    pub name: String,
    /// Its contents.
    pub text: String,
}

impl GeneratedFile {
    pub(crate) fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text }
    }
}

/// All files of a request: the code, a test that compares it with the library's values, a build file, and a
/// report.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[doc(alias = "Generated")]
pub struct GeneratedFiles {
    /// The files, in the order of their names.
    pub files: Vec<GeneratedFile>,
    /// If files and functions cannot have the requested name: their name, and the reason.
    pub renamed: Option<String>,
}

impl GeneratedFiles {
    /// The file of this name.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_generate::{Function, Request, Target, generate};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.file("pendulum.h").is_some_and(|file| file.text.contains("pendulum_gravity")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn file(&self, name: &str) -> Option<&GeneratedFile> {
        self.files.iter().find(|file| file.name == name)
    }

    /// Writes all files into a folder, which is created if it is missing: all of them or none. Files that
    /// were generated are replaced; if another file has the same name, nothing is written.
    ///
    /// ```no_run
    /// # use robot_dynamics_generate::{Function, Request, Target, generate};
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// generated.write("pendulum")?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`GenerateError::Foreign`] and [`GenerateError::File`].
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), GenerateError> {
        let paths = self.paths(folder);
        for path in &paths {
            match fs::read(path) {
                Ok(bytes) => {
                    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(2000)]).into_owned();
                    if !head.contains(heading::MARK) {
                        return Err(GenerateError::Foreign { path: path.clone() });
                    }
                }
                Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => {}
                Err(cause) => return Err(GenerateError::File { path: path.clone(), cause }),
            }
        }
        let files: Vec<_> = paths.into_iter().zip(self.files.iter().map(|file| &file.text)).collect();
        write_files(&files).map_err(|NotWritten { path, cause, .. }| GenerateError::File { path, cause })
    }

    /// The paths of all files in a folder, in their order.
    ///
    /// ```
    /// use robot_dynamics_generate::{Function, Request, Target, generate};
    /// let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.paths("arm").contains(&std::path::Path::new("arm").join("pendulum.h")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn paths(&self, folder: impl AsRef<Path>) -> Vec<PathBuf> {
        self.files.iter().map(|file| folder.as_ref().join(&file.name)).collect()
    }
}
