//! Folders of generated code, compiled and run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use generate::Generated;

/// What is written beside the code: the names of its files.
const NAMES: &str = "names.txt";

/// A folder with generated code.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    /// This code alone; where an earlier run has left the same, with what was compiled of it.
    pub(crate) fn of(name: &str, generated: &Generated) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("generated").join(name);
        let has =
            |name: &str, text: &str| fs::read_to_string(path.join(name)).is_ok_and(|found| found == text);
        let names: Vec<&str> = generated.files.iter().map(|file| file.name.as_str()).collect();
        let names = names.join("\n");
        if !has(NAMES, &names) || !generated.files.iter().all(|file| has(&file.name, &file.text)) {
            let _ = fs::remove_dir_all(&path);
            generated.write(&path).unwrap();
            fs::write(path.join(NAMES), names).unwrap();
        }
        Self(path)
    }

    /// Compiles to the file that the arguments end with. Not again what the same compiler has compiled by the same arguments: any
    /// other code in this folder takes away what was made here.
    pub(crate) fn compile(&self, compiler: &str, arguments: &[&str]) {
        let how = format!("{}{arguments:?}", self.run(compiler, &["--version"]));
        let note = self.0.join(format!("{}.made", arguments.last().unwrap()));
        if !fs::read_to_string(&note).is_ok_and(|made| made == how) {
            let _ = fs::remove_file(&note);
            self.run(compiler, arguments);
            fs::write(note, how).unwrap();
        }
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
