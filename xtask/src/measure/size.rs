//! The lines and files of each crate.

use super::rust_file::RustFile;
use crate::files;

/// The size of a crate.
pub(super) struct CrateSize {
    /// Its folder below `crates/`.
    pub(super) folder: String,
    /// Files of its sources.
    pub(super) files: usize,
    /// Lines of its sources without tests, comments and blank lines included.
    pub(super) lines: usize,
    /// Lines of them with code.
    pub(super) code_lines: usize,
    /// Lines of tests, benchmarks and examples, unit tests included.
    pub(super) test_lines: usize,
}

/// The sizes of all crates.
pub(super) fn sizes(rust: &[RustFile]) -> Result<Vec<CrateSize>, String> {
    let mut sizes = Vec::new();
    for folder in files::crate_folders()? {
        let mut size = CrateSize { folder, files: 0, lines: 0, code_lines: 0, test_lines: 0 };
        let prefix = format!("crates/{}/", size.folder);
        for file in rust.iter().filter(|file| file.path.starts_with(&prefix)) {
            let lines = file.text.lines().count();
            if file.is_test {
                size.test_lines += lines;
                continue;
            }
            size.files += 1;
            // A unit test's lines have code that is blanked; comments inside it lie between such lines.
            let tests = unit_test_lines(file);
            size.lines += lines - tests;
            size.test_lines += tests;
            size.code_lines += file.code.lines().filter(|line| !line.trim().is_empty()).count();
        }
        sizes.push(size);
    }
    Ok(sizes)
}

/// Lines of unit tests: from each `#[cfg(test)]` on a line of its own to the next line that has code again,
/// or the end.
fn unit_test_lines(file: &RustFile) -> usize {
    let (mut count, mut in_tests) = (0, false);
    for (text, code) in file.text.lines().zip(file.code.lines()) {
        let has_code = !code.trim().is_empty();
        if has_code {
            in_tests = false;
        } else if text.trim_start().starts_with("#[cfg(test)]") {
            in_tests = true;
        }
        count += usize::from(in_tests);
    }
    count
}
