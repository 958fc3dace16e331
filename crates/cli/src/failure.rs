//! What a command returns: an exit code, or what went wrong: one line, or one for each error of a file.

use std::fmt;
use std::process::ExitCode;

use multibody::text::one_line;

/// The cause of a failed command: one line, and one more for each error of a file with several.
#[derive(Debug)]
pub(crate) struct Failure(String);

/// What a command returns.
pub(crate) type Outcome = Result<ExitCode, Failure>;

impl Failure {
    pub(crate) fn new(cause: impl fmt::Display) -> Self {
        // A cause of several lines would break the promise of one.
        Self(one_line(&cause.to_string().replace('\n', " ")).into_owned())
    }

    /// A head line, and a line for each cause below it.
    pub(crate) fn several(head: &str, causes: impl Iterator<Item = String>) -> Self {
        let line = |text: &str| one_line(&text.replace('\n', " ")).into_owned();
        Self(causes.fold(line(head), |text, cause| text + "\n  " + &line(&cause)))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Adds what was being done to the cause of an error.
pub(crate) trait Context<T> {
    fn context(self, doing: impl fmt::Display) -> Result<T, Failure>;
}

impl<T, E: fmt::Display> Context<T> for Result<T, E> {
    fn context(self, doing: impl fmt::Display) -> Result<T, Failure> {
        self.map_err(|cause| Failure::new(format!("{doing}: {cause}")))
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::new(error)
    }
}
