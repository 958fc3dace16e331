//! Folders of generated code, compiled and run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use robot_dynamics_generate::GeneratedFiles;

/// The file with the names of the generated files.
const NAMES: &str = "names.txt";

/// A folder with generated code.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    /// A folder with only this code. If an earlier run wrote the same code, its compiled files are kept.
    pub(crate) fn of(name: &str, generated: &GeneratedFiles) -> Self {
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

    /// Compiles to the file that the arguments end with, unless the same compiler has compiled it with the
    /// same arguments. Other code in this folder removes the compiled files.
    pub(crate) fn compile(&self, compiler: &str, arguments: &[&str]) {
        let how = format!("{}{arguments:?}", self.run(compiler, &["--version"]));
        let note = self.0.join(format!("{}.made", arguments.last().unwrap()));
        if !fs::read_to_string(&note).is_ok_and(|made| made == how) {
            let _ = fs::remove_file(&note);
            self.run(compiler, arguments);
            fs::write(note, how).unwrap();
        }
    }

    /// The output of a command, which must succeed.
    pub(crate) fn run(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).current_dir(&self.0).output();
        let output = output.unwrap_or_else(|error| panic!("{program}: {error}"));
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{program} {arguments:?} in {}:\n{out}\n{err}", self.0.display());
        format!("{out}{err}")
    }

    /// The output of a command, which must fail.
    pub(crate) fn fail(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).current_dir(&self.0).output().unwrap();
        assert!(!output.status.success(), "{program} {arguments:?} in {} succeeds", self.0.display());
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

/// The output of a generated test program that passes in five states: to the last bit, or within a tolerance.
pub(crate) fn summary(functions: usize, is_exact: bool) -> String {
    let claim = if is_exact { "as the library's recursions, to the last bit" } else { "as the library's" };
    format!("robot: {functions} functions in 5 states, {claim}\n")
}
