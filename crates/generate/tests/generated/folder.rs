//! Folders of generated code, compiled and run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use generate::Generated;

/// A folder with generated code.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn of(name: &str, generated: &Generated) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("generated").join(name);
        let _ = fs::remove_dir_all(&path);
        generated.write(&path).unwrap();
        Self(path)
    }

    /// What a command prints; it must succeed.
    pub(crate) fn run(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).current_dir(&self.0).output();
        let output = output.unwrap_or_else(|error| panic!("{program}: {error}"));
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{program} {arguments:?} in {}:\n{out}\n{err}", self.0.display());
        format!("{out}{err}")
    }

    /// What a command prints that must fail.
    pub(crate) fn fail(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).current_dir(&self.0).output().unwrap();
        assert!(!output.status.success(), "{program} {arguments:?} in {} succeeds", self.0.display());
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}
