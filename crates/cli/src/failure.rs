//! Results of commands: an exit code or an error message.

use std::fmt;
use std::process::ExitCode;

use robot_dynamics::text::one_line;

/// The error message of a failed command: one line, and one for each error of a file with several.
#[derive(Debug)]
pub(crate) struct Failure(String);

/// The result of a command.
pub(crate) type CommandResult = Result<ExitCode, Failure>;

impl Failure {
    pub(crate) fn new(cause: impl fmt::Display) -> Self {
        // A message is one line, even if its cause has several.
        Self(one_line(&cause.to_string().replace('\n', " ")).into_owned())
    }

    /// A first line, and a line for each cause below it.
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

/// Adds the failed operation to the cause of an error.
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
